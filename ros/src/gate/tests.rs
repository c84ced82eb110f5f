use super::*;
use crate::pressure::PressureMessage;
use pneudrive_host::poller::ChannelLimit;
use pneudrive_record::messages::FluidPressure;
use pneudrive_record::messages::JointState;

const NOW_NS: u64 = 1_763_742_822_000_000_000;
const AGE_NS: u64 = 500_000_000;
const KPA: [f64; 4] = [0.0, 100.0, 200.0, 300.0];
const SCALE: SensorScale = SensorScale::ORIGINAL;

fn limited(max_kpa: f64) -> (CommandGate, SetPoints) {
    let points = SetPoints::new(2);
    let limit = ChannelLimit { max_kpa, max_rate_kpa_s: f64::INFINITY };
    let limits = Limits::everywhere(limit).unwrap();
    let names = ChannelNames::new(5, None, 1);
    let joint = Joint { names, board: 1, index: 1, limits, scales: [SCALE; CHANNELS] };
    (CommandGate::new(points.clone(), joint), points)
}

fn gate() -> (CommandGate, SetPoints) {
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

fn offer(gate: &CommandGate, message: &JointState) -> Result<(), Refusal> {
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

/// Of two controllers of one joint, one that goes on does not renew what the other, which has died,
/// commanded.
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
