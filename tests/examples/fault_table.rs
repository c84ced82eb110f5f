//! Makes the fault table of docs/reliability.md.
//!
//! ```console
//! $ cargo run -p system-tests --example fault_table             # prints it
//! $ cargo run -p system-tests --example fault_table -- --write  # puts it into docs/reliability.md
//! ```
//!
//! `--only TEXT` runs the faults whose name contains it, `--strangers` the second table alone.
//! Virtual time and fixed seeds: equal code gives an equal table.

use pneudrive_host::bus::FormatPolicy;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use system_tests::fault_table::{
    Boards, Case, HEADER, STRANGERS_HEADER, Setting, Speech, Stranger, cases, meet, row, run, strangers_row,
    strangers_written_into, written_into,
};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let only = arguments.iter().position(|a| a == "--only").and_then(|at| arguments.get(at + 1));
    let wanted = |case: &&Case| only.is_none_or(|only| case.fault.contains(only.as_str()));
    let rows: Vec<(Boards, Case)> = [Boards::Native, Boards::Chips]
        .into_iter()
        .flat_map(|boards| cases().iter().map(move |case| (boards, case)))
        .filter(|(_, case)| wanted(case))
        .map(|(boards, case)| (boards, *case))
        .collect();
    let strangers = STRANGERS_HEADER.to_owned() + &strangers_rows();
    print!("{strangers}");
    let write_it = arguments.iter().any(|argument| argument == "--write");
    if arguments.iter().any(|argument| argument == "--strangers") {
        return if write_it {
            write(|text| strangers_written_into(text, &strangers))
        } else {
            ExitCode::SUCCESS
        };
    }
    let table = HEADER.to_owned() + &made_by_all_cores(&rows).concat();
    print!("{table}");
    if write_it {
        return write(|text| written_into(&strangers_written_into(text, &strangers)?, &table));
    }
    ExitCode::SUCCESS
}

fn strangers_rows() -> String {
    let row = |(boards, stranger)| {
        strangers_row(stranger, boards, &Speech::ALL.map(|speech| meet(boards, stranger, speech)))
    };
    let rows = [Boards::Native, Boards::Chips]
        .into_iter()
        .flat_map(|boards| Stranger::ALL.map(|stranger| (boards, stranger)));
    rows.map(row).collect()
}

/// The rows' text, in order.
fn made_by_all_cores(rows: &[(Boards, Case)]) -> Vec<String> {
    let next = AtomicUsize::new(0);
    let made = Mutex::new(vec![String::new(); rows.len()]);
    let work = || {
        while let Some(&(boards, case)) = rows.get(next.fetch_add(1, Ordering::Relaxed)) {
            let [unchecked, checked] = [FormatPolicy::Unchecked, FormatPolicy::Checked]
                .map(|frames| run(Setting { boards, frames, sessions: false, case }));
            let row = row(case, boards, &unchecked, &checked);
            let mut made = made.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(place) = rows.iter().position(|other| *other == (boards, case)) {
                made[place] = row;
            }
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(work);
        }
    });
    made.into_inner().unwrap_or_else(PoisonError::into_inner)
}

fn write(renewed: impl Fn(&str) -> Option<String>) -> ExitCode {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/reliability.md");
    let written = std::fs::read_to_string(&page)
        .map_err(|error| error.to_string())
        .and_then(|text| renewed(&text).ok_or_else(|| "it has no place for the table".to_owned()))
        .and_then(|text| std::fs::write(&page, text).map_err(|error| error.to_string()));
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}: {error}", page.display());
            ExitCode::FAILURE
        }
    }
}
