//! The state machines of docs/reliability.md: every edge that is drawn there is taken, and no
//! other.

use crate::common::{Bench, counts, packet};
use pneudrive_control::{AdcSample, BoardConfig, BoardState, ChannelStatus, Micros, SensorFault};
use pneudrive_protocol::{CheckedPacket, Counts, Direction, Sequence};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use std::collections::BTreeSet;

/// A board whose times are short, so that a story of some seconds goes round often.
fn quick() -> BoardConfig {
    BoardConfig {
        power_up_vent: Micros::from_millis(20),
        command_timeout: Micros::from_millis(10),
        hold_time: Micros::from_millis(15),
        fault_after_steps: 3,
        recover_after_steps: 5,
        ..BoardConfig::default()
    }
}

/// Edges seen when something happens at random before each of so many steps.
fn edges(
    config: BoardConfig,
    steps: usize,
    mut act: impl FnMut(&mut Bench, &mut Pcg32),
    state: impl Fn(&Bench) -> String,
) -> BTreeSet<(String, String)> {
    let mut rng = Pcg32::seed_from_u64(1);
    let mut seen = BTreeSet::new();
    for _ in 0..20 {
        let mut bench = Bench::new(config, 0);
        bench.step();
        let mut before = state(&bench);
        for _ in 0..steps {
            act(&mut bench, &mut rng);
            bench.step();
            let after = state(&bench);
            if after != before {
                seen.insert((before, after.clone()));
            }
            before = after;
        }
    }
    seen
}

fn drawn(edges: &[(&str, &str)]) -> BTreeSet<(String, String)> {
    edges.iter().map(|(from, to)| ((*from).to_owned(), (*to).to_owned())).collect()
}

fn board_state(bench: &Bench) -> String {
    format!("{:?}", bench.board.status().state)
}

fn channel_state(bench: &Bench) -> String {
    format!("{:?}", bench.board.status().channels[2])
}

/// Requests that come and stay away for a while.
fn a_moody_host() -> impl FnMut(&mut Bench, &mut Pcg32) {
    let mut silent_for = 0;
    move |bench, rng| {
        if silent_for > 0 {
            silent_for -= 1;
            return;
        }
        bench.request([500; 4]);
        if rng.random_range(0..10) == 0 {
            silent_for = rng.random_range(0..40);
        }
    }
}

#[test]
fn the_board_takes_every_drawn_edge_and_no_other() {
    let seen = edges(quick(), 2_000, a_moody_host(), board_state);
    let expected = [
        ("PowerUpVent", "Running"),
        ("Running", "Hold"),
        ("Hold", "Vent"),
        ("Hold", "Running"),
        ("Vent", "Running"),
    ];
    assert_eq!(seen, drawn(&expected));
}

/// A host that checks, whose requests are now and then damaged, and that leaves now and then.
#[test]
fn the_board_takes_every_edge_of_damage_and_no_other() {
    let mut host = a_moody_host();
    let config = BoardConfig { damage_limit: 2, damage_window: Micros::from_millis(5), ..quick() };
    let act = |bench: &mut Bench, rng: &mut Pcg32| {
        let checked = CheckedPacket { packet: packet(0, [500; 4]), sequence: Sequence::new(3) };
        let mut bytes = checked.encode(Direction::Request);
        match rng.random_range(0..60) {
            0..6 => bytes[5] ^= 1,
            6 => {
                bytes =
                    CheckedPacket::leave(checked.packet.address, checked.sequence).encode(Direction::Request)
            }
            7 => bench.wait_us(20_000),
            8..20 => {}
            _ => return host(bench, rng),
        }
        bench.raw_bytes(&bytes);
        bench.wait_us(150);
    };
    let seen = edges(config, 4_000, act, board_state);
    let damage: BTreeSet<_> =
        seen.into_iter().filter(|(from, to)| from == "DamageVent" || to == "DamageVent").collect();
    assert_eq!(
        damage,
        drawn(&[("PowerUpVent", "DamageVent"), ("Running", "DamageVent"), ("DamageVent", "Running"),])
    );
}

#[test]
fn a_board_that_does_not_hold_goes_from_running_to_vent() {
    let config = BoardConfig { hold_time: Micros::ZERO, ..quick() };
    let seen = edges(config, 2_000, a_moody_host(), board_state);
    assert_eq!(seen, drawn(&[("PowerUpVent", "Running"), ("Running", "Vent"), ("Vent", "Running")]));
}

#[test]
fn a_channel_takes_every_drawn_edge_and_no_other() {
    let mut host = a_moody_host();
    let seen = edges(
        quick(),
        4_000,
        |bench, rng| {
            host(bench, rng);
            // A sensor that breaks either way, for one sample or for many.
            if rng.random_range(0..6) == 0 {
                let reading = [0, 1023, 300, 300, 300, 500][rng.random_range(0..6)];
                bench.samples[2] = AdcSample::from(counts(reading));
            }
        },
        channel_state,
    );
    let (low, high) = ("SensorFault(BelowRange)", "SensorFault(AboveRange)");
    let mut expected = drawn(&[
        ("Venting", "Regulating"),
        ("Regulating", "Venting"),
        // The fault's side is the one last seen.
        (low, high),
        (high, low),
    ]);
    for fault in [low, high] {
        for healthy in ["Venting", "Regulating"] {
            expected.extend(drawn(&[(healthy, fault), (fault, healthy)]));
        }
    }
    assert_eq!(seen, expected);
}

/// A request heard in each state, in each format: what the valves do after it.
#[test]
fn a_request_is_obeyed_in_every_state_but_the_power_up_vent() {
    for (after_ms, state) in [
        (1, BoardState::PowerUpVent),
        (25, BoardState::Running),
        (32, BoardState::Hold),
        (60, BoardState::Vent),
    ] {
        let mut bench = Bench::new(quick(), 0);
        bench.steps(after_ms);
        assert_eq!(bench.board.status().state, state);
        assert!(bench.request([900; 4]).is_some(), "answered in any state");
        let obeyed = state != BoardState::PowerUpVent;
        assert_eq!(bench.step(), if obeyed { [400; 4] } else { [-400; 4] }, "{state:?}");
    }
}

/// The edges of the format: unknown, checked, forgotten.
#[test]
fn a_host_that_checks_is_believed_alone_until_it_has_fallen_silent() {
    let checked = CheckedPacket { packet: packet(0, [300; 4]), sequence: Sequence::new(3) };
    let checked = checked.encode(Direction::Request);
    let mut bench = Bench::new(quick(), 0);
    bench.steps(25);
    assert!(bench.request([102; 4]).is_some(), "unchecked, and nobody has checked yet");
    assert_eq!(bench.raw_bytes(&checked).len(), 1);
    bench.wait_us(150);
    assert!(bench.request([102; 4]).is_none(), "unchecked, after a checked one");
    bench.steps(9);
    assert!(bench.request([102; 4]).is_none(), "9 ms later");
    bench.steps(2);
    assert_eq!(bench.board.status().state, BoardState::Hold);
    assert!(bench.request([102; 4]).is_some(), "the silence is over the timeout: another host may speak");
}

/// Control steps that stay away so long that the board finds itself in `Vent` without having been
/// in `Running`.
#[test]
fn a_late_step_that_skips_states_forgets_the_host_all_the_same() {
    let checked = CheckedPacket { packet: packet(0, [300; 4]), sequence: Sequence::new(3) };
    let mut bench = Bench::new(quick(), 0);
    bench.step();
    assert_eq!(bench.raw_bytes(&checked.encode(Direction::Request)).len(), 1);
    bench.wait_us(1_000_000);
    bench.step();
    assert_eq!(bench.board.status().state, BoardState::Vent);
    assert_eq!(bench.board.status().counters.command_timeouts, 1);
    assert!(bench.request([102; 4]).is_some(), "an unchecked host");
}

#[test]
fn both_faults_of_a_sensor_vent_in_every_state() {
    for (reading, fault) in [(0, SensorFault::BelowRange), (1023, SensorFault::AboveRange)] {
        for after_ms in [1, 25, 32, 60] {
            let mut bench = Bench::new(quick(), 0);
            bench.steps(after_ms);
            bench.samples[1] = AdcSample::from(Counts::saturating(reading));
            for _ in 0..4 {
                bench.step();
            }
            assert_eq!(bench.board.status().channels[1], ChannelStatus::SensorFault(fault));
            bench.request([900; 4]);
            assert_eq!(bench.step()[1], -400);
        }
    }
}
