use crate::args::{BusArgs, TimingArgs};
use crate::connect::bus_options;
use crate::failure::Failure;
use crate::output::outln;
use crate::output::print_json;
use pneudrive_host::Calibration;
use pneudrive_protocol::Baud;
use pneudrive_protocol::pulse::{Parts, Pulse, pulse, resistor_for};
use serde::Serialize;

#[derive(Serialize)]
struct TimingReport {
    baud: u32,
    character_us: f64,
    packet_us: f64,
    exchange_us: f64,
    idle_gap_us: f64,
    answer_timeout_us: f64,
    /// Highest loop rate for 1, 2, 3, 4 boards.
    limit_hz: [f64; 4],
    pulse: PulseReport,
}

#[derive(Serialize)]
struct PulseReport {
    resistor_ohm: u32,
    nominal_us: f64,
    tolerance_us: f64,
    shortest_us: f64,
    longest_us: f64,
}

/// Prints wire times and the 555's resistor for a line rate. Needs no port.
pub fn run(args: &BusArgs, timing: &TimingArgs) -> Result<(), Failure> {
    let options = bus_options(args, 1, &Calibration::default())?;
    let parts = Parts {
        capacitance_pf: whole("--capacitor-nf", timing.capacitor_nf, 1_000.0)?,
        capacitor_tolerance_ppm: whole("--capacitor-tolerance", timing.capacitor_tolerance, 10_000.0)?,
        resistor_tolerance_ppm: whole("--resistor-tolerance", timing.resistor_tolerance, 10_000.0)?,
    };
    let ohm = resistor_for(options.baud, parts).map_err(Failure::input)?;
    let report = report(options.baud, options.answer_timeout().as_nanos() as u64, ohm, pulse(ohm, parts));
    if args.json { print_json(&report) } else { print(&report) }
}

/// `value` x `scale` as a whole number.
fn whole(name: &str, value: f64, scale: f64) -> Result<u32, Failure> {
    let scaled = (value * scale).round();
    if (0.0..=f64::from(u32::MAX)).contains(&scaled) {
        Ok(scaled as u32)
    } else {
        Err(Failure::input(format!("{name} {value}: must be from 0 to {:.0}", f64::from(u32::MAX) / scale)))
    }
}

fn report(baud: Baud, timeout_ns: u64, resistor_ohm: u32, pulse: Pulse) -> TimingReport {
    let us = |ns: u64| ns as f64 * 1e-3;
    TimingReport {
        baud: baud.get(),
        character_us: us(baud.characters_ns(1)),
        packet_us: us(baud.packet_ns()),
        exchange_us: us(baud.exchange_ns()),
        idle_gap_us: us(baud.idle_gap_ns()),
        answer_timeout_us: us(timeout_ns),
        limit_hz: [1, 2, 3, 4].map(|boards| baud.cycle_limit_hz(boards)),
        pulse: PulseReport {
            resistor_ohm,
            nominal_us: us(pulse.nominal_ns),
            tolerance_us: us(pulse.tolerance_ns),
            shortest_us: us(pulse.shortest_ns),
            longest_us: us(pulse.longest_ns),
        },
    }
}

fn print(report: &TimingReport) -> Result<(), Failure> {
    let TimingReport { pulse, limit_hz, .. } = report;
    outln!("{} baud, 8N1", report.baud);
    outln!("  character          {:>10.1} us", report.character_us);
    outln!("  packet (10 bytes)  {:>10.1} us", report.packet_us);
    outln!("  request + answer   {:>10.1} us", report.exchange_us);
    outln!("  idle gap           {:>10.1} us   silence that starts a new frame", report.idle_gap_us);
    outln!(
        "  answer timeout     {:>10.1} us   what a missing board costs the others",
        report.answer_timeout_us
    );
    outln!("  loop rate at most");
    for (boards, hz) in (1..).zip(limit_hz) {
        outln!("    {boards} board(s)       {hz:>10.1} Hz");
    }
    outln!("555 write-enable pulse, t = 1.1 R C");
    outln!(
        "  R                  {:>10} ohm  smallest E96 value that always covers a packet",
        pulse.resistor_ohm
    );
    outln!(
        "  t                  {:>10.1} us   +- {:.1} us (root sum of squares)",
        pulse.nominal_us,
        pulse.tolerance_us
    );
    outln!("  worst case         {:>10.1} us   to {:.1} us", pulse.shortest_us, pulse.longest_us);
    Ok(())
}
