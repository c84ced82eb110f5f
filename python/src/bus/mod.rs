//! The bus: one exchange after the other by hand, or polled in the background.

mod commands;
mod controller;
mod history;
mod poller;
mod port;

pub use controller::PressureController;
pub use poller::Poller;
