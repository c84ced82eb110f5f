//! Every fault arrives where it should, is counted, and leaves alone what it should.

use crate::common::{
    CHARACTER, Host, MS, ScriptedBoard, StillAir, US, drain, faulty_scripted_bus, line, packet, rig,
};
use pneudrive_protocol::Address;
use pneudrive_sim::board::{NativeBoard, NativeBoardConfig};
use pneudrive_sim::bus::{Bus, BusNode, Heard};
use pneudrive_sim::fault::{FaultError, FaultInjector, FaultKind, FaultSpec};
use pneudrive_sim::rig::{RigError, RigOptions};
use std::sync::{Arc, Mutex};

type Log = Arc<Mutex<Vec<(u64, Heard)>>>;

/// A bus with one board that listens, and answers board 0's request of 1 ms at 1.115 ms.
fn one_exchange(faults: &[&str]) -> (Bus, Log) {
    let board = ScriptedBoard::new(0, MS + 115 * US, CHARACTER, &answer());
    let log = board.heard();
    let mut bus = faulty_scripted_bus(vec![board], faults, false);
    bus.send(MS, &request());
    bus.run_until(20 * MS);
    (bus, log)
}

fn request() -> [u8; 10] {
    packet(0, 300).encode()
}

fn answer() -> [u8; 10] {
    packet(0, 110).encode()
}

fn heard_by_board(log: &Log) -> Vec<u8> {
    log.lock().unwrap().iter().map(|(_, heard)| heard.byte).collect()
}

fn bits_apart(a: &[u8], b: &[u8]) -> u32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a ^ b).count_ones()).sum()
}

#[test]
fn without_faults_nothing_is_touched_and_nothing_counted() {
    let (mut bus, log) = one_exchange(&[]);
    assert_eq!((drain(&mut bus), heard_by_board(&log)), (answer().to_vec(), request().to_vec()));
    assert!(bus.counters().faults.is_empty());
}

#[test]
fn a_bit_flip_inverts_one_bit_of_one_character_that_way_only() {
    let (mut bus, log) = one_exchange(&["bit_flip@0,on=requests"]);
    assert_eq!(bits_apart(&heard_by_board(&log), &request()), 1);
    assert_eq!(drain(&mut bus), answer());
    assert_eq!(bus.counters().fault("bit_flip"), 1);

    let (mut bus, log) = one_exchange(&["bit_flip=1,on=answers"]);
    assert_eq!(heard_by_board(&log), request());
    assert_eq!(bits_apart(&drain(&mut bus), &answer()), 10);
    assert_eq!(bus.counters().fault("bit_flip"), 10);
}

#[test]
fn a_dropped_byte_is_missing_and_the_others_move_up() {
    let (mut bus, log) = one_exchange(&["drop@0,on=requests", "drop@0.001155,on=answers"]);
    assert_eq!(heard_by_board(&log), request()[1..]);
    let last = log.lock().unwrap().last().map(|(at, _)| *at);
    assert_eq!(last, Some(MS + 9 * CHARACTER));
    // 1.155 ms is the end of the answer's fourth character.
    let expected: Vec<u8> = (0..10).filter(|n| *n != 3).map(|n| answer()[n]).collect();
    assert_eq!(drain(&mut bus), expected);
    assert_eq!(bus.counters().fault("drop"), 2);
}

#[test]
fn a_duplicated_byte_comes_twice() {
    let (mut bus, log) = one_exchange(&["duplicate@0,on=requests", "duplicate=1,on=answers"]);
    assert_eq!(heard_by_board(&log), [&[0xFF], &request()[..]].concat());
    assert_eq!(drain(&mut bus), answer().iter().flat_map(|byte| [*byte; 2]).collect::<Vec<_>>());
    assert_eq!(bus.counters().fault("duplicate"), 11);
}

#[test]
fn a_delayed_byte_holds_back_those_behind_it() {
    let (mut bus, log) = one_exchange(&["delay@0,on=requests,ms=0.5", "delay@0.001155,on=answers,ms=3.2"]);
    assert_eq!(log.lock().unwrap()[0].0, MS + 500 * US + CHARACTER);
    let times: Vec<u64> = std::iter::from_fn(|| bus.receive()).map(|byte| byte.at_ns).collect();
    assert_eq!(times[..3], [1_125_000, 1_135_000, 1_145_000]);
    assert_eq!(times[3..], [1_155_000 + 3_200_000; 7]);
    assert_eq!(bus.counters().fault("delay"), 2);
}

#[test]
fn an_echo_returns_the_hosts_bytes_before_the_answer() {
    let (mut bus, _) = one_exchange(&["echo=1"]);
    assert_eq!(drain(&mut bus), [request(), answer()].concat());
    assert_eq!(bus.counters().fault("echo"), 10);
    assert_eq!(bus.counters().violations(), 0);
}

#[test]
fn a_stray_byte_is_heard_by_everybody_on_a_silent_line() {
    let (mut bus, log) = one_exchange(&["stray@0.0005"]);
    let heard = drain(&mut bus);
    assert_eq!((heard.len(), heard_by_board(&log).len()), (11, 11));
    assert_eq!(log.lock().unwrap()[0].0, 510_000);
    assert_eq!(heard[1..], answer());
    assert_eq!((bus.counters().fault("stray"), bus.counters().violations()), (1, 0));
}

#[test]
fn a_stray_byte_inside_a_character_spoils_it_instead() {
    let (mut bus, log) = one_exchange(&["stray@0.001023"]);
    let heard = heard_by_board(&log);
    // It began in the third character and reached into the fourth.
    let spoiled: Vec<usize> = (0..10).filter(|&n| heard[n] != request()[n]).collect();
    assert_eq!((heard.len(), spoiled), (10, vec![2, 3]));
    assert_eq!((drain(&mut bus).len(), bus.counters().collisions), (10, 0));
}

#[test]
fn a_noise_burst_spoils_what_it_covers_and_fills_silence() {
    let (_, quiet_log) = one_exchange(&["noise@0.005,ms=1"]);
    let in_silence = quiet_log.lock().unwrap().iter().filter(|(at, _)| *at > 5 * MS).count();
    assert!((20..100).contains(&in_silence), "{in_silence} characters in 1 ms of noise");
    assert_eq!(heard_by_board(&quiet_log)[..10], request());

    let (bus, log) = one_exchange(&["noise@0.0009,ms=0.3"]);
    assert_ne!(heard_by_board(&log), request());
    assert_eq!((bus.counters().fault("noise"), bus.counters().collisions), (1, 0));
}

#[test]
fn an_unplugged_board_is_deaf_and_mute_and_comes_back() {
    let mut bus = rig(2, &["unplug@0.01,board=1,ms=20"]);
    let host = Host::default();
    let mut alive = Vec::new();
    while bus.now_ns() < 50 * MS {
        let now = bus.now_ns();
        assert!(host.exchange(&mut bus, packet(0, 102)).is_some(), "board 0 at {now}");
        alive.push((now, host.exchange(&mut bus, packet(1, 102)).is_some()));
    }
    let unplugged = |now: u64| (10 * MS..30 * MS).contains(&now);
    // An exchange that begins before the plug is pulled may end after.
    assert!(alive.iter().all(|&(now, ok)| ok != unplugged(now) || now.abs_diff(10 * MS) < MS));
    assert_eq!(bus.counters().fault("unplug"), 1);
}

#[test]
fn a_babbling_board_drowns_the_others_for_as_long_as_it_lasts() {
    let mut bus = rig(2, &["babble@0.01,board=1,ms=5"]);
    let host = Host::default();
    assert!(host.exchange(&mut bus, packet(0, 102)).is_some());
    bus.run_until(11 * MS);
    assert_eq!(host.exchange(&mut bus, packet(0, 102)), None);
    bus.run_until(16 * MS);
    drain(&mut bus);
    assert!(host.exchange(&mut bus, packet(0, 102)).is_some());
    // 5 ms of characters back to back, and its own answers swallowed.
    assert_eq!(bus.counters().board_characters, 500 + 20);
    assert_eq!(bus.counters().fault("babble"), 1);
    assert!(bus.counters().collisions > 0 && bus.counters().overlong > 0);
}

#[test]
fn a_power_cycle_vents_the_valves_and_restarts_the_board() {
    let air = StillAir { code: 410, ..StillAir::default() };
    let drives = Arc::clone(&air.drives);
    let specs: Vec<FaultSpec> = vec!["power_cycle@3,board=0,ms=100".parse().unwrap()];
    let faults = FaultInjector::new(&specs, line(), 1, 1).unwrap();
    let board = NativeBoard::new(NativeBoardConfig::default(), Address::of_board(0), 0, line()).unwrap();
    let nodes: Vec<Box<dyn BusNode + Send>> = vec![Box::new(board)];
    let mut bus = Bus::new(line(), nodes, Box::new(air), faults, true);
    let host = Host::default();

    // Past the power-up vent a board at atmosphere that is to reach 500 counts fills.
    while bus.now_ns() < 2_950 * MS {
        assert!(host.exchange(&mut bus, packet(0, 500)).is_some());
        bus.run_until(bus.now_ns() + 10 * MS);
    }
    assert_eq!(drives.lock().unwrap().last().map(|last| last.2), Some([1.0; 4]));

    bus.run_until(3_050 * MS);
    assert_eq!(drives.lock().unwrap().last().copied(), Some((0, 3_000 * MS, [-1.0; 4])));
    assert_eq!(host.exchange(&mut bus, packet(0, 500)), None);

    // 100 ms without supply, 128 ms of boot; then 2 s of power-up vent.
    bus.run_until(3_230 * MS);
    assert!(host.exchange(&mut bus, packet(0, 500)).is_some());
    assert_eq!(drives.lock().unwrap().last().map(|last| last.2), Some([-1.0; 4]));
    assert_eq!(bus.counters().fault("power_cycle"), 1);
}

#[test]
fn rates_are_what_they_say() {
    let mut bus = rig(1, &["drop=0.01,on=requests", "stray=50", "unplug=2,ms=1"]);
    let host = Host { timeout_ns: MS };
    while bus.now_ns() < 10_000 * MS {
        host.exchange(&mut bus, packet(0, 102));
        drain(&mut bus);
        bus.run_until(bus.now_ns() + 5 * MS);
    }
    let sent = bus.counters().host_characters + bus.counters().fault("drop");
    // Three standard deviations of the binomial or Poisson counts.
    let near = |count: u64, mean: f64| (count as f64 - mean).abs() < 3.0 * mean.sqrt();
    assert!(near(bus.counters().fault("drop"), 0.01 * sent as f64), "{:?}", bus.counters());
    assert!(near(bus.counters().fault("stray"), 500.0), "{:?}", bus.counters());
    assert!(near(bus.counters().fault("unplug"), 20.0), "{:?}", bus.counters());
}

#[test]
fn equal_seeds_give_equal_faults_and_other_seeds_others() {
    let run = |seed| {
        let faults = FaultKind::ALL.map(|kind| kind.example().parse().unwrap()).to_vec();
        let options = RigOptions { boards: 3, faults, seed, ..RigOptions::default() };
        let mut bus = options.build().unwrap();
        let host = Host::default();
        let mut heard = Vec::new();
        for n in (0..3).cycle().take(1_000) {
            heard.push(host.exchange_bytes(&mut bus, &packet(n, 400).encode()));
        }
        (heard, bus.counters().clone())
    };
    let first = run(7);
    assert_eq!(first, run(7));
    assert_ne!(first, run(8));
}

#[test]
fn a_fault_of_a_board_that_is_not_there_is_refused() {
    let faults = vec!["unplug@1,board=3".parse().unwrap()];
    let error = RigOptions { boards: 3, faults, ..RigOptions::default() }.build().err().unwrap();
    let RigError::Fault(FaultError::NoSuchBoard { board, boards, .. }) = error else { panic!("{error}") };
    assert_eq!((board, boards), (3, 3));
}
