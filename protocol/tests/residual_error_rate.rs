//! What goes unnoticed of damaged packets, as docs/reliability.md states it.

#[path = "../examples/residual_error_rate/rates.rs"]
mod rates;

use rates::{HIGHEST, LOWEST, Weights};

/// Every row of the table is what the code's weights give, to the digits that stand there.
#[test]
fn the_documents_rates_are_those_of_the_code() {
    let document = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/reliability.md");
    let document = std::fs::read_to_string(document).expect("the document");
    let section = document.split("### Residual error rate").nth(1).expect("the section");
    let weights = Weights::of_checked_packets();
    let mut rows = 0;
    for row in section
        .lines()
        .skip_while(|line| !line.starts_with("| ---"))
        .skip(1)
        .take_while(|line| line.starts_with('|'))
    {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let residual = weights.residual(if cells[0].contains("maximum") {
            weights.worst_rate()
        } else {
            number(cells[0])
        });
        for (cell, computed) in [
            (cells[1], residual.a_packet),
            (cells[2], residual.per_hour),
            (cells[3], residual.two_that_agree_per_hour),
        ] {
            let stated = number(cell);
            assert!(
                (stated / computed - 1.0).abs() < 0.04,
                "{row}: {stated:e} stated, {computed:e} computed"
            );
        }
        rows += 1;
    }
    assert_eq!(rows, 7);
}

/// The maximum is sought: no rate of another grid is worse, and it is where the document says.
#[test]
fn no_bit_error_rate_is_worse_than_the_one_found() {
    let weights = Weights::of_checked_packets();
    let worst_rate = weights.worst_rate();
    let worst = weights.residual(worst_rate).a_packet;
    assert!((0.3..=HIGHEST).contains(&worst_rate), "{worst_rate}");
    let steps = 777;
    for step in 0..=steps {
        let rate = LOWEST + (HIGHEST - LOWEST) * f64::from(step) / f64::from(steps);
        assert!(weights.residual(rate).a_packet <= worst, "{rate}");
    }
    // A random word fits a CRC of 16 bits as often as that.
    assert!((worst * 65_536.0 - 1.0).abs() < 1e-3, "{worst}");
}

/// The first number of a cell: `**1.526e-5** (2^-16)`, `6.1e-26`, `211`.
fn number(cell: &str) -> f64 {
    let word =
        cell.trim_matches(|letter| letter == '*' || letter == ' ').split(['*', ' ']).next().unwrap_or("");
    word.parse().unwrap_or_else(|_| panic!("{cell}: no number"))
}
