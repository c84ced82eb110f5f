//! What was found about a machine, in words.

use super::held_out::HeldOut;
use super::report::Found;
use crate::diagnosis::json::{Report, Verdict};
use crate::diagnosis::report::verdict;
use crate::effects::catalogue::CATALOGUE;

impl Found<'_> {
    /// The sentence at the head of a report that has everything else.
    pub(super) fn sentence(&self, report: &Report) -> String {
        let loads = if self.findings.known {
            "The machine's valves are taken as they were calibrated. ".to_owned()
        } else {
            format!("These are {} recordings of one machine with different loads. ", self.names.len())
        };
        let found = found(report, &self.findings.held_out, self.findings.known);
        format!("{loads}{found}{}{}{}", rest(report), self.moved(report), verdict::asked_about(&report.asked))
    }

    /// Whether what is likeliest is no matter of the load, where the machine is a calibrated one
    /// and nothing was named.
    fn moved(&self, report: &Report) -> String {
        let Some((likeliest, _)) = self.findings.candidates.first() else { return String::new() };
        if !self.findings.known || !report.causes.is_empty() {
            return String::new();
        }
        let of_load = |effect: &usize| CATALOGUE[*effect].parameters.iter().any(|p| p.of_load);
        let effects = likeliest.missing.effects();
        let odd: Vec<&str> = effects.iter().filter(|e| !of_load(e)).map(|&e| CATALOGUE[e].title).collect();
        if odd.is_empty() {
            return String::new();
        }
        format!(
            " The likeliest is none of the load: \"{}\". The machine may not be what it was when it was calibrated (`--reference` asks what has moved), or the calibrated model is not good enough: calibrate it with more recordings.",
            odd.join("\" and \"")
        )
    }
}

/// What is missing, and how large the error is on what was used for nothing else. `held_out`:
/// without names, and with them.
fn found(report: &Report, [before, after]: &[HeldOut; 2], known: bool) -> String {
    let noise = report.baseline.noise_floor_kpa;
    let from = if known {
        "the last third of the recording, which was used for nothing else,"
    } else {
        "the last third of each recording, simulated with what the others say of the machine,"
    };
    let (was, is) = (before.rmse_kpa(), after.rmse_kpa());
    if report.causes.is_empty() {
        let error = format!("on {from} its error is {was:.2} kPa (sensor noise {noise:.2} kPa).");
        return if report.verdict == Verdict::Adequate {
            format!("The model is adequate: {error}")
        } else {
            let cause =
                if report.asked.is_empty() { "no known cause" } else { "nothing that was asked about" };
            format!("The model misses something, and {cause} explains it: {error}")
        };
    }
    let names: Vec<String> = report.causes.iter().map(verdict::name).collect();
    let gain = before.gain(after);
    let [low, high] = gain.ci95.map(|g| 100.0 * g);
    format!(
        "Missing from the model: {}. On {from} the error falls from {was:.2} to {is:.2} kPa ({:.0} % less, 95 % interval {low:.0} to {high:.0} %; sensor noise is {noise:.2} kPa).",
        names.join(" and "),
        100.0 * gain.reduction
    )
}

/// What is left.
fn rest(report: &Report) -> String {
    let depends_on = report.unexplained.depends_on.iter();
    let left: Vec<String> = depends_on.map(|s| s.what.replace("the residual depends on ", "")).collect();
    match report.verdict {
        Verdict::PartlyExplained if left.is_empty() => format!(
            " That is not all: noise and a usual wander of the supply would leave {:.2} kPa.",
            report.checks.allowed_rmse_kpa
        ),
        Verdict::PartlyExplained => {
            format!(" That is not all: what remains still depends on {}.", left.join(", "))
        }
        Verdict::Unexplained if !left.is_empty() => format!(" It depends on {}.", left.join(", ")),
        _ => String::new(),
    }
}
