//! The figures of `bench`, for people.

use crate::bench::BenchRun;
use crate::load::Load;
use crate::original_client::OriginalClient;
use crate::output::outln;
use pneudrive_host::statistics::Statistics;
use std::fmt::Write as _;

/// Longest bar of the histogram, characters.
const BAR: usize = 14;

pub fn print_header(port: &str, baud: u32, cycles: u32) {
    outln!("{port} at {baud} baud, {cycles} cycles each; loop rate in Hz, cycle time in us");
    outln!(
        "boards  wire limit       mean +- std   share      p50     p99   p99.9     max    lost  rejected  CPU  us/exchange"
    );
}

pub fn print_row(run: &BenchRun) {
    let Statistics { devices, loop_hz, cycle_us, lost, rejected, cpu_share, .. } = &run.statistics;
    outln!(
        "{devices:>6}  {:>10.1}  {:>8.1} +- {:<6.1} {:>5.1} %  {:>7.0} {:>7.0} {:>7.0} {:>7.0}  {lost:>6}  {rejected:>8}  {:>2.0} %  {:>11.1}",
        run.wire_limit_hz,
        loop_hz.mean,
        loop_hz.std,
        100.0 * run.wire_share,
        cycle_us.p50,
        cycle_us.p99,
        cycle_us.p999,
        cycle_us.max,
        100.0 * cpu_share,
        1e6 / loop_hz.mean / *devices as f64,
    );
}

/// What stands below the table: the original client's figures, what virtual boards took off, the
/// histogram of the round trips.
pub fn below(runs: &[BenchRun], original: Option<&OriginalClient>) -> String {
    let mut text = original.map_or_else(String::new, |original| beside_the_original(runs, original));
    let load = runs.iter().map(|run| run.load).fold(Load::default(), Load::or_worse);
    text.push_str(&busy(load, original.is_some()));
    let dated: Vec<_> = runs.iter().filter_map(|run| Some(format!("{:.0}", run.dated_back_us?))).collect();
    if !dated.is_empty() {
        let _ = writeln!(text, "virtual boards took off the pty's round trip, us: {}", dated.join(", "));
    }
    text.push_str(&histogram(runs));
    text
}

/// What is to be said of figures that are those of other programs too.
fn busy(load: Load, is_compared: bool) -> String {
    let what = if is_compared { "not a fair comparison" } else { "slower than it can be" };
    let words = load.words();
    words.map_or_else(String::new, |words| {
        format!("{what}: {words};\n  close other programs, or use --realtime\n")
    })
}

/// Mean rates of both, where the original's is known.
fn beside_the_original(runs: &[BenchRun], original: &OriginalClient) -> String {
    let mut text = String::from(
        "boards  here, Hz  core   original client, Hz  core   faster by   published on its hardware, Hz\n",
    );
    for (at, run) in runs.iter().enumerate() {
        let Statistics { devices, loop_hz, cpu_share, .. } = &run.statistics;
        let Some(measured) = original.plain_responder_hz.get(at) else { break };
        let published = original.published_hz.get(at).map_or_else(String::new, |hz| format!("{hz:.0}"));
        // Writing to a String does not fail.
        let _ = writeln!(
            text,
            "{devices:>6}  {:>8.0}  {:>2.0} %  {measured:>20.0}  {:>2.0} %  {:>+8.1} %  {published:>30}",
            loop_hz.mean,
            100.0 * cpu_share,
            100.0 * original.cpu_share,
            100.0 * (loop_hz.mean / measured - 1.0),
        );
    }
    let _ = writeln!(text, "{}", original.source);
    text
}

/// A column for each number of boards: how many exchanges took how long from request to answer. The
/// bars' lengths are logarithmic too, because the rare long ones are what matters.
fn histogram(runs: &[BenchRun]) -> String {
    let bins = || runs.iter().flat_map(|run| &run.round_trip_us);
    let mut edges: Vec<(f64, f64)> = bins().map(|bin| (bin.from_us, bin.to_us)).collect();
    edges.sort_by(|a, b| a.0.total_cmp(&b.0));
    edges.dedup();
    let most = bins().map(|bin| bin.count).max().unwrap_or(0);
    let mut text = String::from(
        "exchanges by their time from request to answer, us; logarithmic bars\n      from      to",
    );
    for run in runs {
        let _ = write!(text, "  {:<width$}", format!("{} board(s)", run.statistics.devices), width = BAR + 9);
    }
    text.push('\n');
    for (from, to) in edges {
        let _ = write!(text, "{from:>10.1} {to:>7.1}");
        for run in runs {
            let bin = run.round_trip_us.iter().find(|bin| bin.from_us == from);
            let count = bin.map_or(0, |bin| bin.count);
            let shown = if count == 0 { String::new() } else { count.to_string() };
            let _ = write!(text, "  {shown:>8} {:<BAR$}", "#".repeat(bar(count, most)));
        }
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    text
}

/// Length of the bar for `count`, characters: 1 for a single one, `BAR` for the most.
fn bar(count: u64, most: u64) -> usize {
    if count == 0 {
        return 0;
    }
    let share = (count as f64).ln() / (most.max(2) as f64).ln();
    1 + (share * (BAR - 1) as f64).round() as usize
}

#[cfg(test)]
mod tests {
    use super::{BAR, bar, busy};
    use crate::load::Load;

    #[test]
    fn figures_of_a_busy_computer_are_said_to_be_such() {
        assert_eq!(busy(Load::default(), true), "");
        let said = busy(Load { core_wait_share: Some(0.68), other_programs_share: None }, true);
        assert!(said.starts_with("not a fair comparison: the computer was busy ("), "{said}");
        assert!(said.contains("waited for a core 68 % of the time"), "{said}");
    }

    #[test]
    fn a_single_outlier_can_be_seen() {
        assert_eq!([0, 1, 1_000_000].map(|count| bar(count, 1_000_000)), [0, 1, BAR]);
        assert_eq!(bar(1_000, 1_000_000), 1 + (BAR - 1).div_ceil(2));
        assert_eq!(bar(1, 1), 1);
    }
}
