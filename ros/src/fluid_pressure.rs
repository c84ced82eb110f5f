//! `sensor_msgs/msg/FluidPressure`: one chamber's pressure, in Pa.

use crate::channel_names::ChannelNames;
use crate::pressure::{Command, Part, PressureMessage};
use pneudrive_protocol::CHANNELS;
use pneudrive_record::messages::{FluidPressure, Header, Time};
use std::borrow::Cow;

const PA_PER_KPA: f64 = 1_000.0;

/// A chamber's pressure, Pa gauge; frame `joint_{n}_chamber_{k}_gauge`.
///
/// The definition of the message calls its value absolute. Boards measure against the atmosphere
/// and nothing here knows how high that is, so the value is gauge pressure, and `frame_id` ends in
/// `_gauge` to say so.
impl PressureMessage for FluidPressure {
    const PARTS: &'static [Part] = &[Part::Chamber(0), Part::Chamber(1), Part::Chamber(2), Part::Chamber(3)];

    fn empty_state(joint: &ChannelNames, part: Part, _bus: usize) -> Self {
        let chamber = part.channel().unwrap_or_default();
        let frame_id = format!("joint_{}_chamber_{chamber}_gauge", joint.joint());
        Self { header: Header { stamp: Time::default(), frame_id }, ..Self::default() }
    }

    fn fill_state(&mut self, part: Part, stamp: Time, measured: [f64; CHANNELS], _: [f64; CHANNELS]) {
        self.header.stamp = stamp;
        self.fluid_pressure = part.channel().map_or(f64::NAN, |channel| measured[channel] * PA_PER_KPA);
    }

    fn command(&self, part: Part) -> Command<'_> {
        Command {
            stamp: self.header.stamp,
            part,
            names: &[],
            kpa: Cow::Owned(vec![self.fluid_pressure / PA_PER_KPA]),
            has_numbers_elsewhere: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pascals_are_a_thousandth_of_a_kilopascal_both_ways() {
        let mut state = FluidPressure::empty_state(&ChannelNames::new(3, None, 0), Part::Chamber(2), 0);
        assert_eq!(state.header.frame_id, "joint_3_chamber_2_gauge");
        state.fill_state(Part::Chamber(2), Time::from_unix_ns(7), [1.0, 2.0, 101.325, 4.0], [0.0; 4]);
        assert_eq!((state.fluid_pressure, state.header.stamp.unix_ns()), (101_325.0, 7));
        let command = state.command(Part::Chamber(2));
        assert_eq!((command.part, &command.kpa[..]), (Part::Chamber(2), &[101.325][..]));
    }
}
