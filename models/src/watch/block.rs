//! A few seconds of innovations, summed up: how far they went along every direction.

/// Length of a block, s.
pub const BLOCK_S: f64 = 5.0;
/// Innovations beyond this many times their recent mean size, or as many standard deviations, count
/// as so many.
const OUTLIER: f64 = 6.0;
/// Innovations over which the mean size is taken.
const RECENT: f64 = 100.0;

/// Limits innovations: one that is far out says little, but where all are far out they are the
/// change, and its shape tells its name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limiter {
    size: f64,
}

impl Default for Limiter {
    fn default() -> Self {
        Self { size: 1.0 }
    }
}

impl Limiter {
    /// An innovation, in standard deviations, as it is counted.
    pub fn limit(&mut self, innovation: f64) -> f64 {
        let most = OUTLIER * self.size.max(1.0);
        let limited = innovation.clamp(-most, most);
        self.size += (limited.abs() - self.size) / RECENT;
        limited
    }
}

/// Sums over a block. Innovations and directions are whitened and in units of the innovations'
/// standard deviation.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// Sum of innovation times direction, for each direction.
    pub score: Vec<f64>,
    /// Sums of the products of two directions: the lower triangle, row by row.
    pub information: Vec<f64>,
    /// Innovations.
    pub count: usize,
}

/// Place of a pair in a lower triangle.
pub fn at(row: usize, column: usize) -> usize {
    let (low, high) = if row < column { (row, column) } else { (column, row) };
    high * (high + 1) / 2 + low
}

impl Block {
    /// Nothing of so many directions.
    pub fn new(directions: usize) -> Self {
        let pairs = directions * (directions + 1) / 2;
        Self { score: vec![0.0; directions], information: vec![0.0; pairs], count: 0 }
    }

    /// Adds an innovation.
    pub fn add(&mut self, innovation: f64, along: &[f64]) {
        let mut pair = self.information.iter_mut();
        for (k, (score, a)) in self.score.iter_mut().zip(along).enumerate() {
            *score += innovation * a;
            // In this order: a pair that is taken is used.
            for (b, sum) in along[..=k].iter().zip(pair.by_ref()) {
                *sum += a * b;
            }
        }
        self.count += 1;
    }

    /// Information along one direction.
    pub fn own(&self, k: usize) -> f64 {
        self.information[at(k, k)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_the_products() {
        let mut block = Block::new(3);
        block.add(2.0, &[1.0, 0.5, -1.0]);
        block.add(-6.0, &[0.0, 1.0, 2.0]);
        assert_eq!(block.score, [2.0, 1.0 - 6.0, -2.0 - 12.0]);
        let pair = |row, column| block.information[at(row, column)];
        assert_eq!([pair(0, 0), pair(1, 1), pair(2, 2)], [1.0, 1.25, 5.0]);
        assert_eq!([pair(1, 2), pair(2, 1), pair(2, 0)], [1.5, 1.5, -1.0]);
        assert_eq!((block.own(2), block.count), (5.0, 2));
    }

    #[test]
    fn a_spike_is_limited_and_what_lasts_is_not() {
        let mut limiter = Limiter::default();
        assert_eq!((limiter.limit(100.0), limiter.limit(-100.0) < -6.0), (6.0, true));
        for _ in 0..300 {
            limiter.limit(8.0);
        }
        assert_eq!(limiter.limit(9.0), 9.0);
    }
}
