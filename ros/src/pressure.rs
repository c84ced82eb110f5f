//! What the types of messages of the pressure topics have in common.

use crate::channel_names::ChannelNames;
use pneudrive_protocol::CHANNELS;
use pneudrive_record::messages::{JointState, Pressures, Time, bus_frame};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::borrow::Cow;

/// What a topic is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// All four chambers of a joint.
    Joint,
    /// One of them, by its channel.
    Chamber(usize),
}

impl Part {
    /// The name of a topic about this part of joint number `joint`.
    pub fn topic(self, joint: u16, what: &str) -> String {
        match self {
            Self::Joint => format!("~/joint_{joint}/{what}"),
            Self::Chamber(channel) => format!("~/joint_{joint}/chamber_{channel}/{what}"),
        }
    }

    /// The channel, where it is one.
    pub fn channel(self) -> Option<usize> {
        match self {
            Self::Joint => None,
            Self::Chamber(channel) => Some(channel),
        }
    }
}

/// What a message asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct Command<'a> {
    /// When it was given; 0 for none.
    pub stamp: Time,
    /// What the topic is about.
    pub part: Part,
    /// Which channel each pressure is for; all of the part in order where this is empty.
    pub names: &'a [String],
    /// Set points, kPa gauge.
    pub kpa: Cow<'a, [f64]>,
    /// Whether there are numbers where no pressures belong.
    pub has_numbers_elsewhere: bool,
}

/// A message that carries the pressures of one board, or one of them.
pub trait PressureMessage: Serialize + DeserializeOwned + Clone + Send + 'static {
    /// What the topics of a joint are about.
    const PARTS: &'static [Part] = &[Part::Joint];

    /// A state of a joint, to be filled in.
    fn empty_state(joint: &ChannelNames, part: Part, bus: usize) -> Self;

    /// Fills in a state: kPa gauge.
    fn fill_state(&mut self, part: Part, stamp: Time, measured: [f64; CHANNELS], command: [f64; CHANNELS]);

    /// As a command.
    fn command(&self, part: Part) -> Command<'_>;
}

impl PressureMessage for JointState {
    fn empty_state(joint: &ChannelNames, _: Part, bus: usize) -> Self {
        Self { name: joint.of_state(), ..Self::state(joint.joint(), bus) }
    }

    fn fill_state(&mut self, _: Part, stamp: Time, measured: [f64; CHANNELS], command: [f64; CHANNELS]) {
        self.fill(stamp, measured.into_iter().chain(command));
    }

    fn command(&self, part: Part) -> Command<'_> {
        Command {
            stamp: self.header.stamp,
            part,
            names: &self.name,
            kpa: Cow::Borrowed(&self.effort),
            has_numbers_elsewhere: !(self.position.is_empty() && self.velocity.is_empty()),
        }
    }
}

impl PressureMessage for Pressures {
    fn empty_state(_: &ChannelNames, _: Part, bus: usize) -> Self {
        let mut message = Self::default();
        message.header.frame_id = bus_frame(bus);
        message
    }

    fn fill_state(&mut self, _: Part, stamp: Time, measured: [f64; CHANNELS], _: [f64; CHANNELS]) {
        self.header.stamp = stamp;
        self.pressure.clear();
        self.pressure.extend(measured);
    }

    fn command(&self, part: Part) -> Command<'_> {
        let kpa = Cow::Borrowed(&self.pressure[..]);
        Command { stamp: self.header.stamp, part, names: &[], kpa, has_numbers_elsewhere: false }
    }
}
