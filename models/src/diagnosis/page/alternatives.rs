//! How probable each explanation is.

use crate::diagnosis::json::Report;
use crate::diagnosis::report::earned::LEAST_PROBABLE;
use crate::diagnosis::report::verdict;
use crate::diagnosis::settings::SETTINGS;
use crate::report::{Align, Markup, Table, significant};

/// The explanations with their probabilities; `units` are what is weighed anew: blocks or
/// recordings.
pub fn markup(report: &Report, units: &str) -> Markup {
    let mut table = Table::new(&[
        ("Missing", Align::Left),
        ("probability", Align::Right),
        ("error where causes are chosen, kPa", Align::Right),
    ]);
    for a in &report.alternatives {
        let names: Vec<&str> = a
            .causes
            .iter()
            .map(|id| match id.as_str() {
                "none" => "nothing",
                "something_else" => "something without a name",
                id => verdict::title(id),
            })
            .collect();
        let row = [names.join(" and "), format!("{:.3}", a.probability), significant(a.select_rmse_kpa, 3)];
        table.row(row);
    }
    let others = 1.0 - report.alternatives.iter().map(|a| a.probability).sum::<f64>();
    if others >= LEAST_PROBABLE {
        table.row(["all others together".to_owned(), format!("{others:.3}"), String::new()]);
    }
    let caption = format!(
        "How often each explanation is the likeliest of all when {units} that were not fitted are weighed anew (Bayesian bootstrap), \
         with all rows together counting as no more than {:.0} independent ones: what no model describes lasts, and is no new evidence in every \
         row. The error is that on the data by which causes are chosen, which are neither fitted nor tested on.",
        SETTINGS.coarsening_rows
    );
    table.caption(&caption).markup()
}
