//! The residual error rate of checked packets in the manner of IEC 61784-3: the figures of docs/reliability.md.
//!
//! ```console
//! $ cargo run --release -p pneudrive-protocol --example residual_error_rate
//! ```
//!
//! From the code's exact weight distribution (MacWilliams' identity, all 69 weights of its 68 bits) comes the probability that a
//! packet is damaged unnoticed, at each bit error rate; its maximum over 1e-6 to 0.5 is sought, because no code need have it
//! at 0.5. The 12 bits that the form fixes are taken as never hit, which makes every figure larger.

use pneudrive_protocol::{Address, CheckedError, CheckedPacket, Counts, Direction, Packet, Sequence};

const BITS: usize = 68;
/// Requests a second that one board can be sent at 1 Mbaud: what the wire lets through.
const REQUESTS_PER_SECOND: f64 = 5_000.0;
const LOWEST: f64 = 1e-6;
const HIGHEST: f64 = 0.5;

fn main() {
    let weights = weight_distribution(&syndromes());
    assert_eq!(weights.iter().sum::<u128>(), 1 << (BITS - 16), "all code words");
    assert_eq!(weights[..6], [1, 0, 0, 0, 0, 0], "Hamming distance 6");
    println!("bit error rate   packet unnoticed   per hour at 5000/s   two that agree, per hour");
    for rate in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.2, 0.3, 0.4, 0.5] {
        print(rate, &weights);
    }
    let worst = worst_rate(&weights);
    println!("the maximum over {LOWEST:e} to {HIGHEST}:");
    print(worst, &weights);
}

fn print(rate: f64, weights: &[u128]) {
    let missed = unnoticed(rate, weights);
    let per_hour = 3_600.0 * REQUESTS_PER_SECOND;
    println!("{rate:12.6} {missed:18.3e} {:20.3e} {:22.3e}", missed * per_hour, missed * missed * per_hour);
}

/// Difference between the CRC that comes and the one that should, for a flip of each bit that the form does not fix.
fn syndromes() -> Vec<u16> {
    let values = [300, 301, 302, 303].map(Counts::saturating);
    let packet = Packet { address: Address::of_board(2), values };
    let sent = CheckedPacket { packet, sequence: Sequence::new(9) }.encode(Direction::Request);
    (8..80)
        .filter_map(|bit| {
            let mut bytes = sent;
            bytes[bit / 8] ^= 0x80 >> (bit % 8);
            match CheckedPacket::decode(&bytes, Direction::Request) {
                Ok(_) => Some(0),
                Err(CheckedError::Crc { expected, got }) => Some(expected ^ got),
                Err(CheckedError::Form(_)) => None,
            }
        })
        .collect()
}

/// How many code words there are of each weight, by MacWilliams' identity from those of the dual code.
fn weight_distribution(syndromes: &[u16]) -> Vec<u128> {
    assert_eq!(syndromes.len(), BITS);
    let mut dual = [0_i128; BITS + 1];
    for mask in 0..=u16::MAX {
        dual[syndromes.iter().filter(|&&syndrome| (syndrome & mask).count_ones() % 2 == 1).count()] += 1;
    }
    // Coefficients of (1 - z)^j (1 + z)^(n - j), summed over the dual's words.
    let mut sums = [0_i128; BITS + 1];
    for (j, &words) in dual.iter().enumerate().filter(|&(_, &words)| words > 0) {
        let mut polynomial = [0_i128; BITS + 1];
        polynomial[0] = 1;
        for factor in 0..BITS {
            let sign = if factor < j { -1 } else { 1 };
            for power in (1..=BITS).rev() {
                polynomial[power] += sign * polynomial[power - 1];
            }
        }
        sums.iter_mut().zip(polynomial).for_each(|(sum, coefficient)| *sum += words * coefficient);
    }
    sums.iter().map(|sum| (sum >> 16) as u128).collect()
}

/// Probability that a packet is damaged and its CRC fits.
fn unnoticed(rate: f64, weights: &[u128]) -> f64 {
    (1..=BITS)
        .map(|weight| {
            weights[weight] as f64 * rate.powi(weight as i32) * (1.0 - rate).powi((BITS - weight) as i32)
        })
        .sum()
}

/// Where that is greatest: on a logarithmic grid of 10,000 rates, then between the neighbours of the best one.
fn worst_rate(weights: &[u128]) -> f64 {
    const STEPS: i32 = 10_000;
    let rate = |step: f64| LOWEST * (HIGHEST / LOWEST).powf((step / f64::from(STEPS)).clamp(0.0, 1.0));
    let worse = |a: &f64, b: &f64| unnoticed(rate(*a), weights).total_cmp(&unnoticed(rate(*b), weights));
    let coarse = (0..=STEPS).map(f64::from).max_by(worse).unwrap_or(0.0);
    let fine = (-1_000..=1_000).map(|part| coarse + f64::from(part) / 1_000.0).max_by(worse);
    rate(fine.unwrap_or(coarse))
}
