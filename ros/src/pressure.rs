//! The two message types of the pressure topics.

use crate::channel_names::ChannelNames;
use pneudrive_host::messages::{JointState, Pressures, Time, bus_frame};
use pneudrive_protocol::CHANNELS;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// What a message asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command<'a> {
    /// When it was given; 0 for none.
    pub stamp: Time,
    /// Which channel each pressure is for; channels 0 to 3 in order where this is empty.
    pub names: &'a [String],
    /// Set points, kPa gauge.
    pub kpa: &'a [f64],
    /// Whether there are numbers where no pressures belong.
    pub has_numbers_elsewhere: bool,
}

/// A message that carries the pressures of one board.
pub trait PressureMessage: Serialize + DeserializeOwned + Clone + Send + 'static {
    /// A state of a joint, to be filled in.
    fn empty_state(joint: &ChannelNames, bus: usize) -> Self;

    /// Fills in a state: kPa gauge.
    fn fill_state(&mut self, stamp: Time, measured: [f64; CHANNELS], command: [f64; CHANNELS]);

    /// As a command.
    fn command(&self) -> Command<'_>;
}

impl PressureMessage for JointState {
    fn empty_state(joint: &ChannelNames, bus: usize) -> Self {
        Self { name: joint.of_state(), ..Self::state(joint.joint(), bus) }
    }

    fn fill_state(&mut self, stamp: Time, measured: [f64; CHANNELS], command: [f64; CHANNELS]) {
        self.fill(stamp, measured.into_iter().chain(command));
    }

    fn command(&self) -> Command<'_> {
        Command {
            stamp: self.header.stamp,
            names: &self.name,
            kpa: &self.effort,
            has_numbers_elsewhere: !(self.position.is_empty() && self.velocity.is_empty()),
        }
    }
}

impl PressureMessage for Pressures {
    fn empty_state(_joint: &ChannelNames, bus: usize) -> Self {
        let mut message = Self::default();
        message.header.frame_id = bus_frame(bus);
        message
    }

    fn fill_state(&mut self, stamp: Time, measured: [f64; CHANNELS], _command: [f64; CHANNELS]) {
        self.header.stamp = stamp;
        self.pressure.clear();
        self.pressure.extend(measured);
    }

    fn command(&self) -> Command<'_> {
        Command { stamp: self.header.stamp, names: &[], kpa: &self.pressure, has_numbers_elsewhere: false }
    }
}
