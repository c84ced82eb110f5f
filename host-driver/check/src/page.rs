//! A check as one page, without anything from elsewhere.

use crate::table::{day, plain, problems, range};
use crate::{Quantity, Report, Verdict};
use std::fmt::Write as _;

const STYLE: &str = "\
:root { color-scheme: light dark; --line: #8885; --pass: #2a8a4a; --warn: #b87a00; --fail: #d0342c; --none: #888; }
body { font: 15px/1.45 system-ui, sans-serif; margin: 1.5rem auto; max-width: 70rem; padding: 0 1rem; }
h1 { font-size: 1.4rem; } h2 { font-size: 1.1rem; margin-top: 2rem; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { border-bottom: 1px solid var(--line); padding: .3rem .5rem; text-align: right; }
th:first-child, td:first-child { text-align: left; }
.pass { color: var(--pass); } .warn { color: var(--warn); } .fail { color: var(--fail); } .not_measured { color: var(--none); }
td.warn, td.fail { font-weight: 600; background: color-mix(in srgb, currentColor 12%, transparent); }
small { display: block; opacity: .75; } .scroll { overflow-x: auto; }
";

/// The page. `name` says what a board and a channel are called.
pub fn page(report: &Report, name: &dyn Fn(u8, Option<usize>) -> String) -> String {
    let mut html = String::new();
    // Writing to a String does not fail.
    let _ = write!(
        html,
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<title>PneuDrive check: {}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
         <h1>Check of {}: <span class=\"{}\">{}</span></h1>\n<p>{}, up to {} kPa.{}</p>\n",
        of_all(report.verdict),
        escaped(&report.port),
        class(report.verdict),
        of_all(report.verdict),
        escaped(&report.started_utc),
        report.level_kpa,
        match report.baseline_utc.as_deref().and_then(day) {
            Some(day) => format!(" Compared with the check of {}.", escaped(&day)),
            None => " Compared with no earlier check.".to_owned(),
        },
    );
    let found = problems(report, name);
    if found.is_empty() {
        html.push_str(match report.verdict {
            Verdict::NotMeasured => "<p>What could be measured is as it should be.</p>\n",
            _ => "<p>Nothing to look after.</p>\n",
        });
    } else {
        html.push_str("<ul>\n");
        found.iter().for_each(|problem| {
            let _ = writeln!(html, "<li>{}</li>", escaped(problem));
        });
        html.push_str("</ul>\n");
    }
    for board in &report.boards {
        let _ = writeln!(
            html,
            "<h2>{}: <span class=\"{}\">{}</span></h2>",
            escaped(&name(board.board, None)),
            class(board.verdict()),
            of_all(board.verdict())
        );
        if let Some(why) = &board.aborted {
            let _ =
                writeln!(html, "<p class=\"{}\">Broken off: {}</p>", class(board.verdict()), escaped(why));
        }
        if board.values.is_empty() {
            continue;
        }
        html.push_str("<div class=\"scroll\"><table>\n<tr><th>quantity</th>");
        for channel in 0..crate::CHANNELS {
            let _ = write!(html, "<th>{}</th>", escaped(&name(board.board, Some(channel))));
        }
        html.push_str("</tr>\n");
        for quantity in Quantity::ALL {
            let _ = write!(html, "<tr><td>{}<small>{}</small></td>", quantity.name(), quantity.unit().name);
            for channel in 0..crate::CHANNELS {
                match board.value(quantity, channel) {
                    None => html.push_str("<td>-</td>"),
                    Some(value) if value.value.is_none() => {
                        let (class, why) = (class(value.verdict), escaped(&value.note));
                        let _ = write!(html, "<td class=\"{class}\">not measured<small>{why}</small></td>");
                    }
                    Some(value) => {
                        let before = value.before.map_or_else(String::new, |before| {
                            format!("<small>before {}</small>", plain(value, Some(before)))
                        });
                        let _ = write!(
                            html,
                            "<td class=\"{}\" title=\"{}\">{} &plusmn; {}<small>{}</small>{before}</td>",
                            class(value.verdict),
                            escaped(&value.note),
                            plain(value, value.value),
                            plain(value, value.interval),
                            escaped(&range(value)),
                        );
                    }
                }
            }
            html.push_str("</tr>\n");
        }
        html.push_str("</table></div>\n");
    }
    html.push_str(
        "<p>Values with half their 95 % interval; below each where it passes.</p>\n</body>\n</html>\n",
    );
    html
}

/// A verdict over many values: one that is missing is not all.
fn of_all(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NotMeasured => "not all measured",
        other => other.name(),
    }
}

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "pass",
        Verdict::NotMeasured => "not_measured",
        Verdict::Warn => "warn",
        Verdict::Fail => "fail",
    }
}

/// Names come from rig files and ports from command lines.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
