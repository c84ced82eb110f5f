//! Whether stated probabilities are right as often as they say.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use super::plan::{Case, Kind};

/// Upper ends of the bins of the reliability diagram.
const BINS: [f64; 7] = [0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0];

/// Probabilities that were stated, and what was true.
#[derive(Debug, Default)]
pub struct Reliability {
    /// Each probability of a set of effects, and whether that set was hidden.
    stated: Vec<(f64, bool)>,
    /// Of each report, the sum over all sets of the squared error of its probability (G. W. Brier,
    /// Monthly Weather Review 78, 1950): 0 to 2.
    brier: Vec<f64>,
    /// Of each report, the probability that the hidden set is not listed, and whether it is not.
    unlisted: Vec<(f64, bool)>,
    /// Of each report, whether the most probable set was the one that was hidden.
    first: Vec<bool>,
}

/// Sets of causes whose probabilities were about the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bin {
    /// Lower end, left out.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// How many.
    pub sets: usize,
    /// Mean of their probabilities.
    pub stated: f64,
    /// How many of them were hidden.
    pub hidden: usize,
}

impl Bin {
    /// Part of the sets that was hidden.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.hidden as f64 / self.sets as f64
    }

    /// Its 95 % interval (E. B. Wilson, Journal of the American Statistical Association 22, 1927).
    #[must_use]
    pub fn share_ci95(&self) -> [f64; 2] {
        let (n, share, z2) = (self.sets as f64, self.share(), 1.96_f64.powi(2));
        let middle = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
        let half = (z2 * (share * (1.0 - share) + z2 / (4.0 * n)) / n).sqrt() / (1.0 + z2 / n);
        [(middle - half).max(0.0), (middle + half).min(1.0)]
    }
}

impl Reliability {
    /// Takes in a report; one without probabilities is left out. Sets that differ in "something
    /// else" only count as one. What is left to 1 is the probability that the hidden set is not
    /// listed.
    pub fn add(&mut self, case: &Case, report: &Value) {
        let Some(alternatives) = report["alternatives"].as_array().filter(|all| !all.is_empty()) else {
            return;
        };
        let mut sets: BTreeMap<BTreeSet<String>, f64> = BTreeMap::new();
        for alternative in alternatives {
            let ids = alternative["causes"].as_array().into_iter().flatten().filter_map(Value::as_str);
            let effects = ids.filter(|id| !["none", "something_else"].contains(id)).map(str::to_owned);
            *sets.entry(effects.collect()).or_default() += alternative["probability"].as_f64().unwrap_or(0.0);
        }
        let hidden: BTreeSet<String> = match case.kind {
            Kind::Null | Kind::OffCatalogue => BTreeSet::new(),
            _ => case.effects.iter().cloned().collect(),
        };
        let others = (1.0 - sets.values().sum::<f64>()).max(0.0);
        let listed = sets.contains_key(&hidden);
        let truth = |is_true: bool| f64::from(u8::from(is_true));
        let listed_error: f64 = sets.iter().map(|(set, p)| (p - truth(*set == hidden)).powi(2)).sum();
        self.brier.push(listed_error + (others - truth(!listed)).powi(2));
        self.unlisted.push((others, !listed));
        let most = sets.iter().max_by(|a, b| a.1.total_cmp(b.1));
        self.first.push(most.is_some_and(|(set, _)| *set == hidden));
        self.stated.extend(sets.iter().map(|(set, &p)| (p.min(1.0), *set == hidden)));
    }

    /// What was stated in each bin of the diagram, and how often it was right.
    #[must_use]
    pub fn bins(&self) -> Vec<Bin> {
        let mut low = 0.0;
        let mut bins = Vec::new();
        for high in BINS {
            let inside: Vec<&(f64, bool)> =
                self.stated.iter().filter(|(p, _)| *p > low && *p <= high).collect();
            let sets = inside.len();
            if sets > 0 {
                let stated = inside.iter().map(|(p, _)| p).sum::<f64>() / sets as f64;
                let hidden = inside.iter().filter(|(_, right)| *right).count();
                bins.push(Bin { low, high, sets, stated, hidden });
            }
            low = high;
        }
        bins
    }

    /// The diagram as a table, and the scores.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = String::from(
            "| stated | sets | mean stated | hidden | share | 95 % |\n|---|--:|--:|--:|--:|--:|\n",
        );
        for bin in self.bins() {
            let [from, to] = bin.share_ci95();
            text.push_str(&format!(
                "| {} to {} | {} | {:.2} | {} | {:.2} | {from:.2} to {to:.2} |\n",
                bin.low,
                bin.high,
                bin.sets,
                bin.stated,
                bin.hidden,
                bin.share()
            ));
        }
        let n = self.brier.len().max(1) as f64;
        let unlisted = self.unlisted.iter().filter(|(_, unlisted)| *unlisted).count();
        let stated = self.unlisted.iter().map(|(p, _)| p).sum::<f64>() / n;
        text.push_str(&format!(
            "\nHidden sets that were not listed: {unlisted}, expected {:.1}\n",
            stated * n
        ));
        let first = self.first.iter().filter(|right| **right).count();
        text.push_str(&format!(
            "\nBrier score {:.3} over {} reports (0 to 2); the most probable set was the hidden one in {first}\n",
            self.brier.iter().sum::<f64>() / n,
            self.brier.len()
        ));
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn something_else_names_nothing_and_a_set_that_was_not_listed_had_no_probability() {
        let report = json!({ "alternatives": [
            { "causes": ["none"], "probability": 0.5 },
            { "causes": ["something_else"], "probability": 0.2 },
            { "causes": ["valve_lag"], "probability": 0.3 },
        ]});
        let mut nothing = Reliability::default();
        nothing.add(&Case::moderate(Kind::Null, &[]), &report);
        nothing.add(&Case::moderate(Kind::OffCatalogue, &["line_water"]), &report);
        assert!(nothing.first.iter().all(|right| *right));
        assert!(nothing.brier.iter().all(|b| (b - 0.18).abs() < 1e-9), "{:?}", nothing.brier);
        let mut lag = Reliability::default();
        lag.add(&Case::moderate(Kind::Single, &["valve_lag"]), &report);
        lag.add(&Case::moderate(Kind::Single, &["supply_sag"]), &report);
        assert_eq!(lag.first, [false, false]);
        assert!((lag.brier[0] - 0.98).abs() < 1e-9 && (lag.brier[1] - 1.58).abs() < 1e-9, "{:?}", lag.brier);
        let mut partly = Reliability::default();
        let report = json!({ "alternatives": [{ "causes": ["valve_lag"], "probability": 0.8 }] });
        partly.add(&Case::moderate(Kind::Single, &["valve_lag"]), &report);
        partly.add(&Case::moderate(Kind::Single, &["supply_sag"]), &report);
        assert!(
            (partly.brier[0] - 0.08).abs() < 1e-9 && (partly.brier[1] - 1.28).abs() < 1e-9,
            "{:?}",
            partly.brier
        );
        let mut none = Reliability::default();
        none.add(&Case::moderate(Kind::Null, &[]), &json!({ "alternatives": [] }));
        assert!(none.brier.is_empty());
    }

    #[test]
    fn the_diagram_counts_how_often_a_stated_probability_was_right() {
        let sure = Reliability {
            stated: vec![(0.9, true), (0.9, true), (0.9, false), (0.1, false), (1.0, true)],
            unlisted: vec![(0.1, false), (0.2, true)],
            brier: vec![0.02, 0.02],
            first: vec![true, true],
        };
        let table = sure.table();
        assert!(table.contains("| 0.8 to 0.95 | 3 | 0.90 | 2 | 0.67 | 0.21 to 0.94 |"), "{table}");
        assert!(table.contains("| 0.95 to 1 | 1 | 1.00 | 1 | 1.00 | 0.21 to 1.00 |"), "{table}");
        assert!(table.contains("Hidden sets that were not listed: 1, expected 0.3"), "{table}");
        assert!(table.contains("Brier score 0.020 over 2"), "{table}");
    }
}
