//! A check as text.

use crate::{BoardReport, Report, Value, Verdict};
use std::fmt::Write as _;

/// One line a quantity and channel, for each board; `name` says what a board and a channel are
/// called.
pub fn table(report: &Report, name: &dyn Fn(u8, Option<usize>) -> String) -> String {
    let mut text = String::new();
    for board in &report.boards {
        // Writing to a String does not fail.
        let _ = writeln!(text, "{}: {}", name(board.board, None), board.verdict().name());
        if let Some(why) = &board.aborted {
            let _ = writeln!(text, "  broken off: {why}");
        }
        put(board, &mut text);
    }
    text
}

/// Every problem in a sentence, the worst first.
pub fn problems(report: &Report, name: &dyn Fn(u8, Option<usize>) -> String) -> Vec<String> {
    let since = report.baseline_utc.as_deref().and_then(day);
    let mut found: Vec<(Verdict, String)> = Vec::new();
    for board in &report.boards {
        if let Some(why) = &board.aborted {
            found.push((board.verdict(), format!("{}: broken off: {why}", name(board.board, None))));
        }
        for value in board.problems() {
            let place = name(board.board, Some(value.channel));
            let now = number(value, value.value);
            let text = match (value.before, &since) {
                (Some(before), Some(since)) if value.value.is_none() => format!(
                    "{place}: {} could not be measured, {} on {since} ({})",
                    value.quantity.name(),
                    number(value, Some(before)),
                    value.note
                ),
                _ if value.value.is_none() => {
                    format!("{place}: {} could not be measured ({})", value.quantity.name(), value.note)
                }
                (Some(_), Some(since)) if value.note.starts_with("leaks") => {
                    format!("{place} {} as on {since} ({now} now)", value.note)
                }
                (Some(before), Some(since)) => format!(
                    "{place}: {} {now} now, {} on {since} ({})",
                    value.quantity.name(),
                    number(value, Some(before)),
                    value.note
                ),
                _ => format!("{place}: {} {now} ({})", value.quantity.name(), value.note),
            };
            found.push((value.verdict, text));
        }
    }
    found.sort_by_key(|(verdict, _)| std::cmp::Reverse(*verdict));
    found.into_iter().map(|(verdict, text)| format!("{}: {text}", verdict.name())).collect()
}

fn put(board: &BoardReport, text: &mut String) {
    if board.values.is_empty() {
        return;
    }
    let _ = writeln!(
        text,
        "  {:<16} {:>2}  {:>10} {:>9}  {:<23} {:>10}  verdict",
        "quantity", "ch", "value", "+- 95 %", "passes within", "before"
    );
    let mut values: Vec<&Value> = board.values.iter().collect();
    values.sort_by_key(|value| (value.quantity, value.channel));
    for value in values {
        let unit = value.quantity.unit();
        let _ = writeln!(
            text,
            "  {:<16} {:>2}  {:>10} {:>9}  {:<23} {:>10}  {}{}",
            value.quantity.name(),
            value.channel,
            plain(value, value.value),
            plain(value, value.interval),
            if value.value.is_some() { format!("{} {}", range(value), unit.name) } else { "-".to_owned() },
            plain(value, value.before),
            value.verdict.name(),
            if value.note.is_empty() { String::new() } else { format!(": {}", value.note) },
        );
    }
}

/// Where it passes.
pub(crate) fn range(value: &Value) -> String {
    let number = |number| plain(value, Some(number));
    match value.limits {
        (Some(from), Some(to)) => format!("{} to {}", number(from), number(to)),
        (None, Some(to)) => format!("at most {}", number(to)),
        (Some(from), None) => format!("at least {}", number(from)),
        (None, None) => "no limit".to_owned(),
    }
}

/// A number with the decimals of the quantity.
pub(crate) fn plain(value: &Value, number: Option<f64>) -> String {
    let decimals = value.quantity.unit().decimals;
    number.map_or_else(|| "-".to_owned(), |number| format!("{number:.decimals$}"))
}

fn number(value: &Value, number: Option<f64>) -> String {
    format!("{} {}", plain(value, number), value.quantity.unit().name)
}

/// `3 November` of `2026-11-03T..`; with the year.
pub(crate) fn day(utc: &str) -> Option<String> {
    const MONTHS: [&str; 12] = [
        "January",
        "February",
        "March",
        "April",
        "May",
        "June",
        "July",
        "August",
        "September",
        "October",
        "November",
        "December",
    ];
    let mut parts = utc.get(..10)?.split('-');
    let (year, month, day) = (parts.next()?, parts.next()?, parts.next()?);
    let month = MONTHS.get(month.parse::<usize>().ok()?.checked_sub(1)?)?;
    Some(format!("{} {month} {year}", day.parse::<u8>().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Quantity;

    /// A check of one value that is compared with the day before, and how its problems and its
    /// table read.
    fn told(value: Value) -> (Vec<String>, String) {
        let board = BoardReport { board: 0, values: vec![value], aborted: None, unjudged: false };
        let report = Report {
            started_utc: "2026-11-23T10:00:00Z".into(),
            port: "sim".into(),
            level_kpa: 150.0,
            stretch: 1.0,
            baseline_utc: Some("2026-11-03T09:00:00Z".into()),
            verdict: Verdict::Warn,
            boards: vec![board],
        };
        let name = |board: u8, channel: Option<usize>| match channel {
            Some(channel) => format!("board {board}, channel {channel}"),
            None => format!("board {board}"),
        };
        (problems(&report, &name), table(&report, &name))
    }

    #[test]
    fn what_could_not_be_measured_has_no_number() {
        let value = |before: Option<f64>| Value {
            quantity: Quantity::Threshold,
            channel: 1,
            value: None,
            interval: None,
            limits: (None, Some(30.0)),
            before,
            verdict_alone: Verdict::Warn,
            verdict: Verdict::Warn,
            note: "the pressure did not move".to_owned(),
        };
        assert_eq!(
            told(value(Some(5.25))).0,
            [
                "warn: board 0, channel 1: valve threshold could not be measured, 5.25 kPa on 3 November 2026 (the pressure did not move)"
            ]
        );
        assert_eq!(
            told(value(None)).0,
            ["warn: board 0, channel 1: valve threshold could not be measured (the pressure did not move)"]
        );
    }

    #[test]
    fn a_leak_is_told_in_a_sentence() {
        let (problems, table) = told(Value {
            quantity: Quantity::Leak,
            channel: 2,
            value: Some(6.0),
            interval: Some(0.3),
            limits: (Some(0.5), Some(2.5)),
            before: Some(1.5),
            verdict_alone: Verdict::Pass,
            verdict: Verdict::Warn,
            note: "leaks 4.0 times as much".to_owned(),
        });
        assert_eq!(
            problems,
            ["warn: board 0, channel 2 leaks 4.0 times as much as on 3 November 2026 (6.00 kPa/s now)"]
        );
        assert!(table.contains("leak              2        6.00      0.30  0.50 to 2.50 kPa/s"), "{table}");
    }
}
