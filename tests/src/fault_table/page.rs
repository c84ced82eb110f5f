use super::{Boards, Case, Outcome};

/// The table's head. In every cell: unchecked packets / checked packets.
pub const HEADER: &str = "\
| fault | boards | struck | exchanges tried | lost | wrong pressures believed | wrong commands obeyed | recovery, ms | oldest command at a valve, ms |
| --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

const BEGIN: &str = "<!-- the fault table: made by the command above, do not edit -->\n";
const END: &str = "<!-- the fault table ends -->\n";

/// A row of the table.
pub fn row(case: Case, boards: Boards, unchecked: &Outcome, checked: &Outcome) -> String {
    let both = |of: fn(&Outcome) -> String| format!("{} / {}", of(unchecked), of(checked));
    let cells = [
        format!("`{}`", case.fault),
        boards.name().to_owned(),
        both(|outcome| outcome.struck.to_string()),
        both(|outcome| outcome.tried.to_string()),
        both(|outcome| outcome.lost.to_string()),
        both(|outcome| outcome.wrong_pressures.to_string()),
        both(|outcome| outcome.wrong_commands.to_string()),
        both(|outcome| ms(outcome.recovery_ns)),
        both(|outcome| ms(outcome.oldest_command_ns)),
    ];
    format!("| {} |\n", cells.join(" | "))
}

fn ms(ns: u64) -> String {
    format!("{:.1}", ns as f64 / 1e6)
}

/// `page` with this table in its place; `None` if it has no such place.
pub fn written_into(page: &str, table: &str) -> Option<String> {
    let (before, rest) = page.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}{table}{END}{after}"))
}
