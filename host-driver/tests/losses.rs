//! What lost exchanges cost a board of the original kind, whose answers do not say which request
//! they belong to. In virtual time.

use crate::support::virtual_line::{AT_ONCE, Reply, VirtualLine};
use crate::support::{answer, counts};
use pneudrive_host::bus::{Bus, BusOptions, EchoMode, FormatPolicy};
use pneudrive_host::line::Line;
use pneudrive_host::poller::{Pace, PollerOptions, Polling, SetPoints};
use pneudrive_host::statistics::Statistics;
use pneudrive_protocol::Echo;
use std::time::Duration;

const MS: u64 = 1_000_000;

fn bus(script: impl FnMut(usize, &[u8]) -> Reply + Send + 'static) -> Bus<VirtualLine> {
    let options = BusOptions::default().echo(EchoMode::Known(Echo::Absent)).formats(FormatPolicy::Unchecked);
    Bus::new(VirtualLine::new(script), options).unwrap()
}

/// A pressure that tells which request it answers.
fn numbered(number: usize) -> u16 {
    number as u16 % 1024
}

/// As the original's loop makes it: up to 859 us after the request.
fn late(number: usize) -> u64 {
    number as u64 * 613_000 % 859_000
}

/// A number that looks random, of the `number`-th request.
fn hash(number: usize) -> u64 {
    (number as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40
}

/// Two boards at 250 Hz for a minute; every `one_in`-th exchange or so with board 0 is lost.
fn run(one_in: u64) -> Statistics {
    let bus = bus(move |number, request| {
        let board = 0xFF - request[1];
        if board == 0 && number > 2_000 && hash(number).is_multiple_of(one_in) {
            return Vec::new();
        }
        vec![(AT_ONCE + late(number), answer(board, 500))]
    });
    let pace = Pace::every(Duration::from_millis(4));
    let options = PollerOptions::for_devices(2).pace(pace);
    let mut polling = Polling::new(bus, options, Box::new(SetPoints::new(2)), Vec::new());
    while polling.bus_mut().line().now_ns() < 60_000 * MS {
        let at_ns = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(at_ns);
        polling.cycle().unwrap();
    }
    polling.finish()
}

/// One in twenty lost: about one row in twenty is without a reading, and no pauses add to that.
#[test]
fn a_lost_exchange_costs_its_own_row() {
    let statistics = run(20);
    let (rows, boards) = (statistics.cycles, &statistics.boards);
    let without = boards[0].rows_without_reading;
    assert!(boards[0].lost > 500, "{statistics:?}");
    assert!(
        without >= boards[0].lost && without <= boards[0].lost * 11 / 10,
        "{without} of {rows}: {statistics:?}"
    );
    assert_eq!((boards[1].lost, boards[1].rows_without_reading), (0, 0));
}

/// Rows are counted whatever the reason: a board that was not asked has no reading either.
#[test]
fn rows_without_a_reading_are_counted() {
    let statistics = run(1);
    let board = &statistics.boards[0];
    let rows_with = statistics.cycles - board.rows_without_reading;
    assert_eq!(rows_with, board.answered, "{statistics:?}");
    assert!(board.rows_without_reading > 100 * board.lost / 10, "{statistics:?}");
}

/// An answer that is late only once, by whatever time, after a thousand prompt ones: the board is
/// asked again before it comes, and it is not believed. The board says nothing else meanwhile, so
/// what it is asked then is late too.
#[test]
fn a_late_answer_after_many_prompt_ones_passes_for_no_other() {
    for late_us in (0..12_000).step_by(53) {
        let mut bus = bus(move |number, request| {
            let late_ns = if number == 1_200 { late_us * 1000 } else { late(number) / 8 };
            vec![(AT_ONCE + late_ns, answer(0xFF - request[1], numbered(number)))]
        });
        bus.line_mut().one_speaker = true;
        let mut lost = 0;
        for _ in 0..1_300 {
            match bus.exchange(0, counts(102)) {
                Ok(answer) => {
                    let number = bus.line().requests.len() - 1;
                    assert_eq!(answer.pressures, counts(numbered(number)), "late by {late_us} us");
                }
                Err(_) => lost += 1,
            }
        }
        assert!(lost <= 4, "{lost} lost when one is late by {late_us} us");
    }
}
