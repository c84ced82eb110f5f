//! The two message types of the pressure topics.

use pneudrive_host::messages::{JointState, Pressures, Time, bus_frame};
use pneudrive_protocol::CHANNELS;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A message that carries the pressures of one board.
pub trait PressureMessage: Serialize + DeserializeOwned + Clone + Send + 'static {
    /// A state of `joint`, to be filled in.
    fn empty_state(joint: u16, bus: usize) -> Self;

    /// Fills in a state: kPa gauge.
    fn fill_state(&mut self, stamp: Time, measured: [f64; CHANNELS], command: [f64; CHANNELS]);

    /// As a command: its stamp and pressures, kPa gauge.
    fn command(&self) -> (Time, &[f64]);
}

impl PressureMessage for JointState {
    fn empty_state(joint: u16, bus: usize) -> Self {
        Self::state(joint, bus)
    }

    fn fill_state(&mut self, stamp: Time, measured: [f64; CHANNELS], command: [f64; CHANNELS]) {
        self.fill(stamp, measured.into_iter().chain(command));
    }

    fn command(&self) -> (Time, &[f64]) {
        // Some tools can only fill in positions.
        (self.header.stamp, if self.effort.is_empty() { &self.position } else { &self.effort })
    }
}

impl PressureMessage for Pressures {
    fn empty_state(_joint: u16, bus: usize) -> Self {
        let mut message = Self::default();
        message.header.frame_id = bus_frame(bus);
        message
    }

    fn fill_state(&mut self, stamp: Time, measured: [f64; CHANNELS], _command: [f64; CHANNELS]) {
        self.header.stamp = stamp;
        self.pressure.clear();
        self.pressure.extend(measured);
    }

    fn command(&self) -> (Time, &[f64]) {
        (self.header.stamp, &self.pressure)
    }
}
