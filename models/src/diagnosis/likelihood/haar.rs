//! Residuals of a loop that hunts, octave by octave.

/// Octaves of frequencies that are told apart, from half the sampling rate down.
const OCTAVES: usize = 4;
/// Errors that are tried, per factor of e ...
const ERROR_STEPS: i32 = 10;
/// ... from and to these powers of e.
const ERRORS: [i32; 2] = [-1, 10];

/// What two simulations that hunt out of step say about an octave of frequencies in a block.
#[derive(Debug, Clone, Copy)]
pub struct Octave {
    /// Sum of squares of the residuals from the mean over all courses of the noise.
    pub fair: f64,
    /// Sum of squares of the hunting.
    pub hunting: f64,
    /// Coefficients.
    pub count: f64,
}

impl Octave {
    /// Minus twice the log-likelihood with an error of this variance beside the hunting, up to a
    /// constant.
    #[must_use]
    pub fn deviance(self, error: f64) -> f64 {
        let variance = error + self.hunting / self.count.max(1.0);
        self.fair / variance + self.count * variance.ln()
    }

    fn of(coefficients: impl Iterator<Item = [f64; 2]>) -> Self {
        coefficients.fold(Self { fair: 0.0, hunting: 0.0, count: 0.0 }, |sum, [a, b]| Self {
            fair: sum.fair + a * b,
            hunting: sum.hunting + 0.5 * (a - b) * (a - b),
            count: sum.count + 1.0,
        })
    }
}

/// Splits the residuals of two simulations by octaves with the orthonormal Haar wavelet (Percival
/// and Walden, Wavelet Methods for Time Series Analysis, 2000, ch. 4): the fastest changes first,
/// what is slower than the last octave at the end. The product of the two has the mean square of
/// their common part, half of their squared difference that of the hunting.
#[must_use]
pub fn octaves(one: &[f64], other: &[f64]) -> Vec<Octave> {
    let mut found = Vec::new();
    let mut slow: Vec<[f64; 2]> = one.iter().zip(other).map(|(a, b)| [*a, *b]).collect();
    while found.len() < OCTAVES && slow.len() > 1 {
        let (pairs, odd) = slow.as_chunks::<2>();
        let half = core::f64::consts::FRAC_1_SQRT_2;
        let fast = pairs.iter().map(|[x, y]| [half * (x[0] - y[0]), half * (x[1] - y[1])]);
        found.push(Octave::of(fast.chain(odd.iter().copied())));
        slow = pairs.iter().map(|[x, y]| [half * (x[0] + y[0]), half * (x[1] + y[1])]).collect();
    }
    if !slow.is_empty() {
        found.push(Octave::of(slow.into_iter()));
    }
    found
}

/// [Deviances](Octave::deviance) of blocks with an error of this variance.
#[must_use]
pub fn deviances(blocks: &[Vec<Octave>], error: f64) -> Vec<f64> {
    blocks.iter().map(|octaves| octaves.iter().map(|o| o.deviance(error)).sum()).collect()
}

/// Deviances of blocks with the error that suits the `open` ones best.
#[must_use]
pub fn beside_error(blocks: &[Vec<Octave>], open: &[bool]) -> Vec<f64> {
    let sum =
        |losses: &[f64]| losses.iter().zip(open).filter(|(_, open)| **open).map(|(l, _)| l).sum::<f64>();
    let errors = (ERRORS[0] * ERROR_STEPS..=ERRORS[1] * ERROR_STEPS)
        .map(|k| deviances(blocks, (f64::from(k) / f64::from(ERROR_STEPS)).exp()));
    errors.min_by(|a, b| sum(a).total_cmp(&sum(b))).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(seed: u64, count: usize) -> Vec<f64> {
        let mut rng = crate::diagnosis::resampling::generator(seed);
        (0..count).map(|_| rand::RngExt::random_range(&mut rng, -1.0..1.0)).collect()
    }

    #[test]
    fn octaves_share_the_whole_error_between_what_is_common_and_what_differs() {
        let (one, other) = (noise(1, 501), noise(2, 501));
        let found = octaves(&one, &other);
        let sum = |of: fn(&Octave) -> f64| found.iter().map(of).sum::<f64>();
        let squares = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>();
        assert_eq!(sum(|o| o.count), 501.0);
        let mean = 0.5 * (squares(&one) + squares(&other));
        assert!((sum(|o| o.fair + o.hunting) / mean - 1.0).abs() < 1e-9);
    }

    /// Limit cycles of the recording's period and of eight times that, on average over where in
    /// their cycles two simulations out of step are.
    #[test]
    fn hunting_of_a_wrong_frequency_is_less_likely() {
        const PHASES: u32 = 5;
        let cycle = |rows: f64, phase: u32| -> Vec<f64> {
            let phase = f64::from(phase) / f64::from(PHASES) + 0.07;
            (0..512).map(|k| 3.0 * (core::f64::consts::TAU * (f64::from(k) / rows + phase)).sin()).collect()
        };
        let measured = cycle(4.0, 0);
        let deviance = |rows: f64| -> f64 {
            let left = |phase: u32| -> Vec<f64> {
                measured.iter().zip(cycle(rows, phase)).map(|(m, y)| m - y).collect()
            };
            let pairs = (0..PHASES * PHASES).map(|k| (k / PHASES, k % PHASES)).filter(|(a, b)| a != b);
            pairs.flat_map(|(a, b)| octaves(&left(a), &left(b))).map(|o| o.deviance(1.0)).sum()
        };
        assert!(deviance(4.0) < 0.8 * deviance(32.0), "{} {}", deviance(4.0), deviance(32.0));
    }

    /// White errors of 4 in one half of the blocks and of 1 in the other, and simulations that hunt
    /// in either half.
    #[test]
    fn hunting_helps_beside_an_error_only_where_the_error_is() {
        let blocks = 8;
        let of = |hunts: &dyn Fn(usize) -> bool| -> f64 {
            let block = |k: usize| {
                let size = |large: bool| if large { 12.0_f64.sqrt() } else { 3.0_f64.sqrt() };
                let simulated = |draw: u64| -> Vec<f64> {
                    let hunting = noise(100 * draw + k as u64, 512);
                    let measured = noise(k as u64, 512);
                    let of = |(m, h): (&f64, &f64)| m * size(k < 4) - if hunts(k) { 3.0 * h } else { 0.0 };
                    measured.iter().zip(&hunting).map(of).collect()
                };
                octaves(&simulated(1), &simulated(2))
            };
            let found: Vec<Vec<Octave>> = (0..blocks).map(block).collect();
            beside_error(&found, &vec![true; blocks]).iter().sum()
        };
        let (still, right, wrong, everywhere) =
            (of(&|_| false), of(&|k| k < 4), of(&|k| k >= 4), of(&|_| true));
        assert!(right < still - 300.0, "{right} {still}");
        assert!(wrong > still, "{wrong} {still}");
        assert!(everywhere > still - 50.0, "{everywhere} {still}");
    }
}
