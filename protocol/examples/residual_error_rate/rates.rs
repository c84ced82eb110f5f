//! How probable it is that a checked packet is damaged and nobody notices, at each bit error rate.

use pneudrive_protocol::{Address, CheckedError, CheckedPacket, Counts, Direction, Packet, Sequence};

/// Bits of a packet that its form does not fix.
const BITS: usize = 68;
/// Requests a second that one board can be sent at 1 Mbaud: what the wire lets through.
const REQUESTS_PER_SECOND: f64 = 5_000.0;
/// The rates among which the worst one is sought.
pub const LOWEST: f64 = 1e-6;
pub const HIGHEST: f64 = 0.5;

/// What goes unnoticed at one bit error rate.
pub struct Residual {
    /// Probability for one packet.
    pub a_packet: f64,
    /// Expected in an hour of as many requests as the wire lets through, all to one board.
    pub per_hour: f64,
    /// The same where two requests in a row must agree: any two unnoticed ones are taken for
    /// agreeing.
    pub two_that_agree_per_hour: f64,
}

/// How many code words of checked packets there are of each weight.
pub struct Weights(Vec<u128>);

impl Weights {
    /// From the code itself.
    ///
    /// # Panics
    /// The code is not one of [`BITS`] bits with 16 check bits and a Hamming distance of 6.
    pub fn of_checked_packets() -> Self {
        let weights = weight_distribution(&syndromes());
        assert_eq!(weights.iter().sum::<u128>(), 1 << (BITS - 16), "all code words");
        assert_eq!(weights[..6], [1, 0, 0, 0, 0, 0], "Hamming distance 6");
        Self(weights)
    }

    /// What goes unnoticed at a bit error rate.
    pub fn residual(&self, rate: f64) -> Residual {
        let missed = self.unnoticed(rate);
        let per_hour = 3_600.0 * REQUESTS_PER_SECOND;
        Residual {
            a_packet: missed,
            per_hour: missed * per_hour,
            two_that_agree_per_hour: missed * missed * per_hour,
        }
    }

    /// Probability that a packet is damaged and its CRC fits.
    fn unnoticed(&self, rate: f64) -> f64 {
        (1..=BITS)
            .map(|weight| {
                self.0[weight] as f64 * rate.powi(weight as i32) * (1.0 - rate).powi((BITS - weight) as i32)
            })
            .sum()
    }

    /// The bit error rate at which that is greatest: on a logarithmic grid of 10,000 rates, then
    /// between the neighbours of the best one.
    pub fn worst_rate(&self) -> f64 {
        const STEPS: i32 = 10_000;
        let rate = |step: f64| LOWEST * (HIGHEST / LOWEST).powf((step / f64::from(STEPS)).clamp(0.0, 1.0));
        let worse = |a: &f64, b: &f64| self.unnoticed(rate(*a)).total_cmp(&self.unnoticed(rate(*b)));
        let coarse = (0..=STEPS).map(f64::from).max_by(worse).unwrap_or(0.0);
        let fine = (-1_000..=1_000).map(|part| coarse + f64::from(part) / 1_000.0).max_by(worse);
        rate(fine.unwrap_or(coarse))
    }
}

/// Difference between the CRC that comes and the one that should, for a flip of each bit that the
/// form does not fix.
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

/// How many code words there are of each weight, by MacWilliams' identity from those of the dual
/// code.
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
