//! The residual error rate of checked packets in the manner of IEC 61784-3: the figures of
//! docs/reliability.md.
//!
//! ```console
//! $ cargo run --release -p pneudrive-protocol --example residual_error_rate
//! ```
//!
//! From the code's exact weight distribution (MacWilliams' identity, all 69 weights of its 68 bits)
//! comes the probability that a packet is damaged unnoticed, at each bit error rate; its maximum
//! over 1e-6 to 0.5 is sought, because no code need have it at 0.5. The 12 bits that the form fixes
//! are taken as never hit, which makes every figure larger.

mod rates;

use rates::{HIGHEST, LOWEST, Residual, Weights};

fn main() {
    let weights = Weights::of_checked_packets();
    println!("bit error rate   packet unnoticed   per hour at 5000/s   two that agree, per hour");
    for rate in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.2, 0.3, 0.4, 0.5] {
        print(rate, &weights.residual(rate));
    }
    let worst = weights.worst_rate();
    println!("the maximum over {LOWEST:e} to {HIGHEST}:");
    print(worst, &weights.residual(worst));
}

fn print(rate: f64, residual: &Residual) {
    let Residual { a_packet, per_hour, two_that_agree_per_hour } = residual;
    println!("{rate:12.6} {a_packet:18.3e} {per_hour:20.3e} {two_that_agree_per_hour:22.3e}");
}
