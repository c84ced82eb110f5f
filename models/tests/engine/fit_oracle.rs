//! Fits against LMFIT on the same samples: `tests/oracle/fits.py`.

use std::collections::HashMap;
use std::path::Path;

use pneudrive_model::fit::{Control, Fit, FitOptions, Problem, Space, Stopping, fit_rates, fit_rollouts};
use pneudrive_model::model::{Model, Nonlinear, column};
use pneudrive_model::rollout::{Chamber, Series};

use crate::engine::oracle::Table;

/// LMFIT's values and standard errors of one fit.
fn reference(fit: &str) -> HashMap<String, (f64, f64)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/oracle/fits.csv");
    let mut reader = csv::Reader::from_path(path).unwrap();
    let rows = reader.records().map(Result::unwrap).filter(|record| &record[0] == fit);
    let number = |cell: &str| cell.parse().unwrap_or(f64::NAN);
    rows.map(|record| (record[1].to_owned(), (number(&record[2]), number(&record[3])))).collect()
}

fn series() -> Series {
    let table = Table::read("fit_inputs.csv");
    let measured = table.column("measured").to_vec();
    let rows = measured.len();
    #[expect(clippy::single_range_in_vec_init)]
    Series::new(column::COUNT, table.inputs(false), measured, vec![1.0; rows], vec![0..rows]).unwrap()
}

fn options() -> FitOptions {
    // LMFIT integrates with one step per sample, so must we.
    let stopping = Stopping { cost_tolerance: 1e-14, ..Stopping::default() };
    FitOptions { starts: 1, integration_tolerance_pa: f64::INFINITY, stopping, ..FitOptions::default() }
}

fn compare(fit: &Fit, reference: &HashMap<String, (f64, f64)>) {
    #[expect(clippy::cast_precision_loss)]
    let cost = fit.rms.powi(2) * fit.residuals as f64;
    let (chi_square, _) = reference["chi_square"];
    assert!((cost / chi_square - 1.0).abs() < 1e-7, "sum of squares {cost}, LMFIT {chi_square}");
    for parameter in &fit.parameters {
        let (value, error) = reference[&parameter.name];
        assert!((parameter.value - value).abs() < 0.01 * error, "{parameter:?}, LMFIT {value} +- {error}");
        // Ours allow for correlated residuals; these are the textbook's, so ours may only be
        // larger.
        let ratio = parameter.standard_error.unwrap() / error;
        assert!(ratio > 0.98, "{parameter:?}, LMFIT {value} +- {error}");
    }
}

#[test]
fn fits_of_rollouts_agree_with_lmfit() {
    let (system, series) = (Chamber::new(Nonlinear::default()), series());
    let space = Space::new(system.model.parameters());
    let problem = Problem { system: &system, series: &series, space };
    let fit = fit_rollouts(&[problem], &options(), Control::none()).remove(0).unwrap();
    compare(&fit, &reference("rollout"));
    let (start_kpa, error) = reference("rollout")["start_kpa"];
    assert!((fit.start_pressures_pa[0][0] * 1e-3 - start_kpa).abs() < 0.01 * error);
    // The noise is white: allowing for correlation must not cost much.
    for parameter in &fit.parameters {
        let (_, error) = reference("rollout")[&parameter.name];
        assert!(parameter.standard_error.unwrap() < 1.25 * error, "{parameter:?}, LMFIT {error}");
    }
}

#[test]
fn fits_of_rates_agree_with_lmfit() {
    let (system, series) = (Chamber::new(Nonlinear::default()), series());
    let space = Space::new(system.model.parameters());
    let problem = Problem { system: &system, series: &series, space };
    let fit = fit_rates(&[problem], 2, &options(), Control::none()).remove(0).unwrap();
    compare(&fit, &reference("rate"));
}
