//! Which commands get through to the boards.

use crate::channel_names::ChannelNames;
use crate::pressure::{Command, Part};
use crate::refusal::{Counters, Refusal};
use pneudrive_host::messages::Time;
use pneudrive_host::poller::{BoardCommand, Limits, SetPoints, VENTED};
use pneudrive_protocol::{CHANNELS, Counts, SensorScale};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Where a joint's commands go, and how high they may be.
#[derive(Debug, Clone)]
pub struct Joint {
    /// What it and its channels are called.
    pub names: ChannelNames,
    /// Its board's number on the bus.
    pub board: u8,
    /// The board's place in the poller's order.
    pub index: usize,
    /// Highest set points.
    pub limits: Limits,
    /// What its channels' counts mean.
    pub scales: [SensorScale; CHANNELS],
}

/// Stands between the command topic of one joint and its board.
#[derive(Debug)]
pub struct Gate {
    set_points: SetPoints,
    joint: Joint,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    counters: Counters,
    /// When each channel's last command was accepted, ns since 1970; `None` while it is vented for want of one.
    commanded_ns: [Option<u64>; CHANNELS],
}

impl Gate {
    /// Commands of `joint` into `set_points`.
    pub fn new(set_points: SetPoints, joint: Joint) -> Self {
        Self { set_points, joint, state: Mutex::default() }
    }

    /// Follows a command that came at `now_ns` since 1970. A stamp of 0 counts as none. No age is too high if `max_age_ns` is 0.
    ///
    /// # Errors
    /// Why it was not followed; that is counted.
    pub fn offer(&self, command: &Command<'_>, now_ns: u64, max_age_ns: u64) -> Result<(), Refusal> {
        let checked = fresh(command.stamp, now_ns, max_age_ns).and_then(|()| self.read(command));
        let mut state = self.lock();
        match checked {
            Ok(changes) => {
                state.counters.accepted += 1;
                for (at_ns, _) in state.commanded_ns.iter_mut().zip(changes).filter(|(_, new)| new.is_some())
                {
                    *at_ns = Some(now_ns);
                }
                self.change(changes);
                Ok(())
            }
            Err(refusal) => {
                *state.counters.refused_for(&refusal) += 1;
                Err(refusal)
            }
        }
    }

    /// Vents the channels whose last command is older than `timeout_ns`; returns whether there were any. Never if that is 0.
    pub fn expire(&self, now_ns: u64, timeout_ns: u64) -> bool {
        let mut state = self.lock();
        let mut changes = [None; CHANNELS];
        for (commanded_ns, change) in state.commanded_ns.iter_mut().zip(&mut changes) {
            let age_ns = commanded_ns.map(|at_ns| now_ns.saturating_sub(at_ns));
            if timeout_ns > 0 && age_ns.is_some_and(|age_ns| age_ns > timeout_ns) {
                *commanded_ns = None;
                *change = Some(Counts::ATMOSPHERE);
            }
        }
        let expired = changes.iter().any(Option::is_some);
        if expired {
            state.counters.timeouts += 1;
            self.change(changes);
        }
        expired
    }

    /// Forgets what was commanded: 0 kPa until the next command.
    pub fn clear(&self) {
        let mut state = self.lock();
        state.commanded_ns = [None; CHANNELS];
        self.change([Some(Counts::ATMOSPHERE); CHANNELS]);
    }

    /// What its joint and its channels are called.
    pub fn names(&self) -> &ChannelNames {
        &self.joint.names
    }

    /// What has come so far.
    pub fn counters(&self) -> Counters {
        self.lock().counters
    }

    /// What a command changes: all four channels, or those that it names.
    fn read(&self, command: &Command<'_>) -> Result<[Option<Counts>; CHANNELS], Refusal> {
        if command.kpa.is_empty() && command.has_numbers_elsewhere {
            return Err(Refusal::NotInEffort);
        }
        let mut changes = [None; CHANNELS];
        if let Part::Chamber(channel) = command.part {
            for &kpa in command.kpa.iter() {
                changes[channel] = Some(self.counts(channel, kpa)?);
            }
            return Ok(changes);
        }
        if command.names.is_empty() {
            if command.kpa.len() != CHANNELS {
                return Err(Refusal::WrongLength { found: command.kpa.len() });
            }
            for (channel, (change, &kpa)) in changes.iter_mut().zip(command.kpa.iter()).enumerate() {
                *change = Some(self.counts(channel, kpa)?);
            }
            return Ok(changes);
        }
        if command.names.len() != command.kpa.len() {
            return Err(Refusal::NamesAndValues { names: command.names.len(), values: command.kpa.len() });
        }
        for (name, &kpa) in command.names.iter().zip(command.kpa.iter()) {
            let names = &self.joint.names;
            let Some(channel) = names.channel(name) else {
                let (joint, known) = (names.joint(), names.known());
                return Err(Refusal::UnknownName { name: name.clone(), joint, known });
            };
            if changes[channel].replace(self.counts(channel, kpa)?).is_some() {
                return Err(Refusal::NamedTwice { name: name.clone() });
            }
        }
        Ok(changes)
    }

    fn counts(&self, channel: usize, kpa: f64) -> Result<Counts, Refusal> {
        if !kpa.is_finite() {
            return Err(Refusal::NotFinite { channel, kpa });
        }
        let Joint { board, limits, scales, .. } = &self.joint;
        let out_of_range = |reason: String| Refusal::OutOfRange { channel, reason };
        let counts = scales[channel].counts(kpa).map_err(|error| out_of_range(error.to_string()))?;
        limits.check(*board, channel, kpa).map_err(|error| out_of_range(error.to_string()))?;
        Ok(counts)
    }

    fn change(&self, changes: [Option<Counts>; CHANNELS]) {
        let index = self.joint.index;
        let mut command: BoardCommand = self.set_points.get(index).unwrap_or(VENTED);
        for (counts, change) in command.iter_mut().zip(changes) {
            *counts = change.unwrap_or(*counts);
        }
        if let Err(error) = self.set_points.set(index, command) {
            log::error!("{error}");
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn fresh(stamp: Time, now_ns: u64, max_age_ns: u64) -> Result<(), Refusal> {
    if max_age_ns == 0 || stamp.is_zero() || now_ns.abs_diff(stamp.unix_ns()) <= max_age_ns {
        return Ok(());
    }
    let age_s = (i128::from(now_ns) - i128::from(stamp.unix_ns())) as f64 * 1e-9;
    Err(Refusal::Stale { age_s, limit_s: max_age_ns as f64 * 1e-9 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pressure::PressureMessage;
    use pneudrive_host::messages::FluidPressure;
    use pneudrive_host::messages::JointState;
    use pneudrive_host::poller::ChannelLimit;

    const NOW_NS: u64 = 1_763_742_822_000_000_000;
    const AGE_NS: u64 = 500_000_000;
    const KPA: [f64; 4] = [0.0, 100.0, 200.0, 300.0];
    const SCALE: SensorScale = SensorScale::ORIGINAL;

    fn limited(max_kpa: f64) -> (Gate, SetPoints) {
        let points = SetPoints::new(2);
        let limit = ChannelLimit { max_kpa, max_rate_kpa_s: f64::INFINITY };
        let limits = Limits::everywhere(limit).unwrap();
        let names = ChannelNames::new(5, None, 1);
        let joint = Joint { names, board: 1, index: 1, limits, scales: [SCALE; CHANNELS] };
        (Gate::new(points.clone(), joint), points)
    }

    fn gate() -> (Gate, SetPoints) {
        limited(f64::INFINITY)
    }

    fn of(kpa: &[f64]) -> JointState {
        JointState { effort: kpa.to_vec(), ..JointState::default() }
    }

    fn named(names: &[&str], kpa: &[f64]) -> JointState {
        JointState { name: names.iter().map(|&name| name.to_owned()).collect(), ..of(kpa) }
    }

    fn stamped(ns: u64, mut message: JointState) -> JointState {
        message.header.stamp = Time::from_unix_ns(ns);
        message
    }

    fn offer(gate: &Gate, message: &JointState) -> Result<(), Refusal> {
        gate.offer(&message.command(Part::Joint), NOW_NS, AGE_NS)
    }

    fn counts(kpa: [f64; 4]) -> Option<BoardCommand> {
        Some(kpa.map(|kpa| SCALE.counts(kpa).unwrap()))
    }

    #[test]
    fn a_good_command_gets_through() {
        let (gate, points) = gate();
        for ns in [NOW_NS, NOW_NS - AGE_NS, NOW_NS + AGE_NS, 0] {
            offer(&gate, &stamped(ns, of(&KPA))).unwrap();
        }
        assert_eq!((points.get(0), points.get(1)), (Some(VENTED), counts(KPA)));
        assert_eq!(gate.counters(), Counters { accepted: 4, ..Counters::default() });
    }

    #[test]
    fn a_bad_one_changes_nothing_and_is_counted() {
        let (gate, points) = gate();
        offer(&gate, &of(&KPA)).unwrap();
        let bad = [
            of(&[1.0, 2.0, 3.0]),
            of(&[1.0; 5]),
            of(&[]),
            of(&[1.0, 2.0, f64::NAN, 4.0]),
            of(&[1.0, 2.0, 3.0, f64::INFINITY]),
            of(&[-1.0, 2.0, 3.0, 4.0]),
            of(&[776.0; 4]),
            stamped(NOW_NS - AGE_NS - 1_000, of(&KPA)),
            stamped(NOW_NS + AGE_NS + 1_000, of(&KPA)),
        ];
        for message in &bad {
            offer(&gate, message).unwrap_err();
        }
        assert_eq!(points.get(1), counts(KPA));
        let expected = Counters {
            accepted: 1,
            wrong_length: 3,
            not_finite: 2,
            out_of_range: 2,
            stale: 2,
            ..Counters::default()
        };
        assert_eq!(gate.counters(), expected);
        assert_eq!(expected.refused(), 9);
    }

    /// 50 metres or radians are not 50 kPa.
    #[test]
    fn positions_and_velocities_are_no_pressures() {
        let (gate, points) = gate();
        let position = JointState { position: vec![50.0; 4], ..JointState::default() };
        let velocity = JointState { velocity: vec![50.0; 4], ..JointState::default() };
        for message in [position.clone(), velocity] {
            assert_eq!(offer(&gate, &message), Err(Refusal::NotInEffort));
        }
        assert_eq!((points.get(1), gate.counters().not_in_effort), (Some(VENTED), 2));
        // Beside pressures they say nothing to us.
        offer(&gate, &JointState { effort: KPA.to_vec(), ..position }).unwrap();
        assert_eq!(points.get(1), counts(KPA));
    }

    #[test]
    fn a_message_about_one_chamber_changes_that_one() {
        let (gate, points) = gate();
        offer(&gate, &of(&KPA)).unwrap();
        let message = |pa| FluidPressure { fluid_pressure: pa, ..FluidPressure::default() };
        let offer = |pa| gate.offer(&message(pa).command(Part::Chamber(2)), NOW_NS, AGE_NS);
        offer(99_000.0).unwrap();
        assert_eq!(points.get(1), counts([0.0, 100.0, 99.0, 300.0]));
        for pa in [f64::NAN, -1_000.0, 776_000.0] {
            offer(pa).unwrap_err();
        }
        assert_eq!((points.get(1), gate.counters().refused()), (counts([0.0, 100.0, 99.0, 300.0]), 3));
    }

    #[test]
    fn names_say_which_channel_a_value_is_for() {
        let (gate, points) = gate();
        let all = ["b5_cmd3_kpa", "b5_cmd0_kpa", "b5_cmd2_kpa", "b5_cmd1_kpa"];
        offer(&gate, &named(&all, &[30.0, 0.0, 20.0, 10.0])).unwrap();
        assert_eq!(points.get(1), counts([0.0, 10.0, 20.0, 30.0]));
        offer(&gate, &named(&["b5_cmd1_kpa"], &[99.0])).unwrap();
        assert_eq!(points.get(1), counts([0.0, 99.0, 20.0, 30.0]));
    }

    #[test]
    fn names_that_are_not_this_joints_are_refused() {
        let (gate, points) = gate();
        let refused = |names: &[&str], kpa: &[f64]| offer(&gate, &named(names, kpa)).unwrap_err().to_string();
        assert!(
            refused(&["left_elbow"], &[1.0])
                .starts_with("left_elbow is no command of joint_5: its names are b5_cmd0_kpa to b5_cmd3_kpa")
        );
        assert!(refused(&["b4_cmd0_kpa"], &[1.0]).starts_with("b4_cmd0_kpa is no command of joint_5"));
        assert!(refused(&["b5_p0_kpa"], &[1.0]).starts_with("b5_p0_kpa is no command of joint_5"));
        assert!(refused(&["b5_cmd0_kpa"; 2], &[1.0; 2]).starts_with("b5_cmd0_kpa is named twice"));
        assert!(refused(&["b5_cmd0_kpa"], &[1.0; 4]).starts_with("1 names for 4 values"));
        assert_eq!((points.get(1), gate.counters().wrong_names), (Some(VENTED), 5));
    }

    #[test]
    fn a_command_above_the_limit_is_refused_with_a_sentence() {
        let (gate, points) = limited(150.0);
        offer(&gate, &of(&[150.0; 4])).unwrap();
        let refused = offer(&gate, &of(&[100.0, 100.0, 150.1, 100.0])).unwrap_err().to_string();
        assert!(
            refused.contains("150.1 kPa for channel 2 of board 1 is above its limit of 150 kPa"),
            "{refused}"
        );
        assert_eq!((points.get(1), gate.counters().out_of_range), (counts([150.0; 4]), 1));
    }

    #[test]
    fn no_age_is_too_high_without_a_limit() {
        let (gate, _) = gate();
        gate.offer(&stamped(1, of(&KPA)).command(Part::Joint), NOW_NS, 0).unwrap();
    }

    #[test]
    fn a_joint_without_commands_is_vented_once() {
        let (gate, points) = gate();
        assert!(!gate.expire(NOW_NS, AGE_NS), "nothing was commanded yet");
        offer(&gate, &of(&KPA)).unwrap();
        assert!(!gate.expire(NOW_NS + AGE_NS, AGE_NS));
        assert!(!gate.expire(NOW_NS + 100 * AGE_NS, 0), "switched off");
        assert!(gate.expire(NOW_NS + AGE_NS + 1, AGE_NS));
        assert!(!gate.expire(NOW_NS + 2 * AGE_NS, AGE_NS), "it is vented already");
        assert_eq!((points.get(1), gate.counters().timeouts), (Some(VENTED), 1));
    }

    #[test]
    fn what_is_cleared_does_not_come_back_by_itself() {
        let (gate, points) = gate();
        offer(&gate, &of(&KPA)).unwrap();
        gate.clear();
        assert_eq!(points.get(1), Some(VENTED));
        assert!(!gate.expire(NOW_NS + 2 * AGE_NS, AGE_NS), "there is nothing to expire");
        offer(&gate, &named(&["b5_cmd1_kpa"], &[99.0])).unwrap();
        assert_eq!(points.get(1), counts([0.0, 99.0, 0.0, 0.0]));
    }

    /// Of two controllers of one joint, one that goes on does not renew what the other, which has died, commanded.
    #[test]
    fn each_channel_has_its_own_deadline() {
        let (gate, points) = gate();
        offer(&gate, &of(&[100.0; 4])).unwrap();
        let later = named(&["b5_cmd2_kpa"], &[50.0]);
        gate.offer(&later.command(Part::Joint), NOW_NS + AGE_NS, AGE_NS).unwrap();
        assert!(gate.expire(NOW_NS + AGE_NS + 1, AGE_NS));
        let mut left = VENTED;
        left[2] = SCALE.counts(50.0).unwrap();
        assert_eq!(points.get(1), Some(left));
    }
}
