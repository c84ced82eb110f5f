//! The bus: one exchange after the other by hand, or polled in the background.
//!
//! ```text
//!   PressureController ──▶ Link ──▶ Bus (by hand)         atexit closes every Link that is left
//!            │              │
//!            │ poll         └────▶ Session ──▶ host::Poller, which has the bus meanwhile
//!            ▼                        ▲
//!          Poller ────────────────────┘
//! ```

mod baud;
mod by_hand;
mod commands;
mod controller;
mod ending;
mod figures;
mod guard;
mod history;
mod interruptible;
mod link;
mod live;
mod opening;
mod owner;
mod poller;
mod poller_settings;
mod port;
mod sensors;
mod session;
mod trajectory;
mod waiting;

pub use controller::PressureController;
pub use live::register_atexit;
pub use poller::Poller;
