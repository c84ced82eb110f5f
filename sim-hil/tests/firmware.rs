//! The firmware's ELF on emulated chips, on the same strict bus as the native boards.
//!
//! The tests that run it need the file: build it (`cargo fw-build --release`), then
//! `PNEUDRIVE_FIRMWARE=target/thumbv6m-none-eabi/release/pneudrive-firmware cargo test -p pneudrive-sim --test firmware -- --ignored`.

#![allow(clippy::unwrap_used)]

mod common;

use common::{Host, MS, drain, packet};
use pneudrive_protocol::{Address, Baud, SensorScale};
use pneudrive_sim::bus::Bus;
use pneudrive_sim::fault::FaultSpec;
use pneudrive_sim::rig::{Firmware, RigError, RigOptions, Timing};

fn refusal(options: RigOptions) -> RigError {
    RigOptions { firmware: Some(Firmware::new(vec![0; 64])), ..options }.build().err().unwrap()
}

#[test]
fn what_firmware_cannot_do_is_refused() {
    let error = refusal(RigOptions { boards: 5, ..RigOptions::default() });
    assert!(matches!(error, RigError::FirmwareBoards { boards: 5 }), "{error}");
    let error = refusal(RigOptions { timing: Timing::Instant, ..RigOptions::default() });
    assert!(matches!(error, RigError::FirmwareTiming), "{error}");
    let error = refusal(RigOptions { baud: Baud::new(115_200).unwrap(), ..RigOptions::default() });
    assert!(matches!(error, RigError::FirmwareTiming), "{error}");
    let error = refusal(RigOptions::default());
    assert!(matches!(error, RigError::Firmware(_)), "{error}");
}

fn chips(boards: usize, faults: &[&str]) -> Bus {
    let path =
        std::env::var_os("PNEUDRIVE_FIRMWARE").expect("PNEUDRIVE_FIRMWARE names the firmware's ELF file");
    let firmware = Some(Firmware::new(std::fs::read(path).unwrap()));
    let faults: Vec<FaultSpec> = faults.iter().map(|text| text.parse().unwrap()).collect();
    let strict = faults.is_empty();
    let mut bus = RigOptions { boards, firmware, faults, strict, ..RigOptions::default() }.build().unwrap();
    bus.run_until(200 * MS); // the boot
    bus
}

#[test]
#[ignore = "needs PNEUDRIVE_FIRMWARE"]
fn four_chips_answer_to_their_own_names_only() {
    let mut bus = chips(4, &[]);
    let host = Host::default();
    for n in 0..2_000_u32 {
        let board = (n % 4) as u8;
        let answer = host.exchange(&mut bus, packet(board, 511));
        assert_eq!(answer.map(|answer| answer.address), Some(Address::of_board(board)), "exchange {n}");
    }
    let counters = bus.counters();
    assert_eq!((counters.requests, counters.answers, counters.violations()), (2_000, 2_000, 0));
}

#[test]
#[ignore = "needs PNEUDRIVE_FIRMWARE"]
fn chips_regulate_the_plant_behind_their_pins() {
    let mut bus = chips(2, &[]);
    let host = Host::default();
    let scale = SensorScale::ORIGINAL;
    let set = scale.counts(300.0).unwrap().get();
    let mut poll = |until_ms: u64, value: u16| {
        let mut last = Vec::new();
        while bus.now_ns() < until_ms * MS {
            last = (0..2).flat_map(|b| host.exchange(&mut bus, packet(b, value)).unwrap().values).collect();
            bus.run_until(bus.now_ns() + MS);
        }
        last.iter().map(|counts| scale.kpa(*counts)).collect::<Vec<f64>>()
    };
    let vented = poll(2_100, 459);
    assert!(vented.iter().all(|kpa| kpa.abs() < 5.0), "power-up vent: {vented:?}");
    let there = poll(4_500, set);
    assert!(there.iter().all(|kpa| (kpa - 300.0).abs() < 4.2), "{there:?}");
    let back = poll(7_000, 102);
    assert!(back.iter().all(|kpa| kpa.abs() < 5.0), "{back:?}");
}

#[test]
#[ignore = "needs PNEUDRIVE_FIRMWARE"]
fn a_chip_that_lost_its_supply_boots_again() {
    let mut bus = chips(2, &["power_cycle@0.3,board=1,ms=50"]);
    let host = Host::default();
    assert!(host.exchange(&mut bus, packet(1, 102)).is_some());
    bus.run_until(320 * MS);
    assert!(host.exchange(&mut bus, packet(0, 102)).is_some());
    assert!(host.exchange(&mut bus, packet(1, 102)).is_none());
    bus.run_until(550 * MS);
    drain(&mut bus);
    assert!(host.exchange(&mut bus, packet(1, 102)).is_some());
}
