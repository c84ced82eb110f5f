//! What every real rig has and no textbook describes exactly: a background of small imperfections,
//! drawn anew for each channel.
//!
//! A method that names causes is worth something only if none of this makes it name one.

use super::noise::{Purpose, normal, stream, uniform};
use super::parameters::ValveParameters;
use super::physics::{ChannelPhysics, GasPhysics, SideVolume};

/// Coefficients of a smooth relative deviation over an argument from 0 to 1, as a polynomial of
/// degree 3 without a constant part.
pub type Deviation = [f64; 3];

/// How large the imperfections are.
#[derive(Debug, Clone, PartialEq)]
pub struct Background {
    /// Smooth deviation of each metering edge's conductance over its opening, relative standard
    /// deviation, 0 to 0.3.
    pub valve_curve: f64,
    /// The same of the flow function over the pressure ratio, 0 to 0.3.
    pub flow_function: f64,
    /// How far the gas is from the exponent that the plant states, towards the isothermal one:
    /// standard deviation of the exponent, 0 to 0.3.
    pub exponent: f64,
    /// Restriction of the tube between valve and chamber, conductance of the open valve over that
    /// of the tube, 0 (no tube) to 0.3.
    pub tube: f64,
    /// Wander of the supply over 2 s beside the slow one, fraction of its gauge pressure, standard
    /// deviation, 0 to 0.2.
    pub fast_wander: f64,
}

/// Correlation time of the fast wander, s.
pub(super) const FAST_WANDER_S: f64 = 2.0;
/// Volume of the tube, m^3: 2 m of 6 mm.
const TUBE_M3: f64 = 57e-6;

impl Background {
    /// None of it.
    #[must_use]
    pub fn none() -> Self {
        Self { valve_curve: 0.0, flow_function: 0.0, exponent: 0.0, tube: 0.0, fast_wander: 0.0 }
    }

    /// Curves that are off by less than a percent, a tube that takes a thirtieth of the valve's
    /// loss, gas a little less than adiabatic, 0.3 % of the supply: the base model then errs by
    /// several times the sensor's noise, since a chamber sums up flows.
    #[must_use]
    pub fn typical() -> Self {
        Self { valve_curve: 0.004, flow_function: 0.004, exponent: 0.01, tube: 0.03, fast_wander: 0.003 }
    }

    /// Volume of the tube between valve and chamber, m^3: none where there is no tube. The gas
    /// behind the valve fills it as well, and no wall gives way there.
    #[must_use]
    pub fn tube_m3(&self) -> f64 {
        if self.tube > 0.0 { TUBE_M3 } else { 0.0 }
    }

    /// Fields with name, value, upper bound and range in words, for checks.
    pub(super) fn checks(&self) -> [(&'static str, f64, f64, &'static str); 5] {
        [
            ("nuisances.background.valve_curve", self.valve_curve, 0.3, "0 to 0.3"),
            ("nuisances.background.flow_function", self.flow_function, 0.3, "0 to 0.3"),
            ("nuisances.background.exponent", self.exponent, 0.3, "0 to 0.3"),
            ("nuisances.background.tube", self.tube, 0.3, "0 to 0.3"),
            ("nuisances.background.fast_wander", self.fast_wander, 0.2, "0 to 0.2"),
        ]
    }

    /// Draws a channel's own imperfections.
    pub(super) fn draw(
        &self,
        valve: &ValveParameters,
        seed: u64,
        place: usize,
        channel: &mut ChannelPhysics,
    ) {
        if *self == Self::none() {
            return;
        }
        let mut rng = stream(seed, Purpose::Background, place);
        let mut deviation = |size: f64| -> Deviation {
            let drawn: [f64; 3] = std::array::from_fn(|_| normal(&mut rng));
            legendre(drawn.map(|x| size * x))
        };
        channel.valve.fill_curve = deviation(self.valve_curve);
        channel.valve.vent_curve = deviation(self.valve_curve);
        channel.chamber.flow = channel.chamber.flow.bent_by(deviation(self.flow_function));
        if let GasPhysics::Fixed { exponent } = &mut channel.chamber.gas {
            *exponent = (*exponent - self.exponent * normal(&mut rng).abs()).max(1.0);
        }
        if self.tube > 0.0 {
            // Not less: with a wider tube the pressures at its ends would be one.
            let restriction = self.tube * (0.9 + 0.4 * uniform(&mut rng));
            channel.chamber.line = Some(SideVolume {
                conductance: valve.conductance_m3_per_s_pa / restriction,
                volume_m3: self.tube_m3(),
            });
        }
    }
}

/// The polynomial whose parts of degree 1, 2 and 3 over 0 to 1 are orthogonal and of the given root
/// mean squares, without its constant.
fn legendre([a, b, c]: [f64; 3]) -> Deviation {
    // Shifted Legendre polynomials 2x - 1, 6x^2 - 6x + 1, 20x^3 - 30x^2 + 12x - 1, over their root
    // mean squares.
    let [a, b, c] = [a * 3.0_f64.sqrt(), b * 5.0_f64.sqrt(), c * 7.0_f64.sqrt()];
    [2.0 * a - 6.0 * b + 12.0 * c, 6.0 * b - 30.0 * c, 20.0 * c]
}

/// `1 + d(x)`, and at least a tenth.
#[inline]
pub(super) fn factor(deviation: &Deviation, x: f64) -> f64 {
    (1.0 + x * (deviation[0] + x * (deviation[1] + x * deviation[2]))).max(0.1)
}

#[cfg(test)]
mod tests {
    use super::super::parameters::PlantParameters;
    use super::*;

    fn drawn(background: &Background, place: usize) -> ChannelPhysics {
        let parameters = PlantParameters::default();
        let mut channel = parameters.channel_physics();
        background.draw(&parameters.valve, 7, place, &mut channel);
        channel
    }

    #[test]
    fn nothing_is_drawn_where_there_is_none() {
        let channel = drawn(&Background::none(), 0);
        assert_eq!(channel.valve.fill_curve, [0.0; 3]);
        assert!(channel.chamber.line.is_none());
        assert_eq!(factor(&[0.0; 3], 0.7).to_bits(), 1.0_f64.to_bits());
    }

    #[test]
    fn every_channel_and_every_edge_has_its_own() {
        let background = Background::typical();
        let (first, second) = (drawn(&background, 0), drawn(&background, 1));
        assert_ne!(first.valve.fill_curve, second.valve.fill_curve);
        assert_ne!(first.valve.fill_curve, first.valve.vent_curve);
        assert!(
            matches!(first.chamber.gas, GasPhysics::Fixed { exponent } if exponent < 1.4 && exponent > 1.3)
        );
    }

    /// Over 2000 channels, of the part that no gain takes up: three coefficients of one size each.
    #[test]
    fn curves_deviate_by_their_size() {
        let background = Background { valve_curve: 0.02, ..Background::none() };
        let (mut sum, mut count) = (0.0, 0.0_f64);
        for place in 0..2000 {
            let curve = drawn(&background, place).valve.fill_curve;
            let values: Vec<f64> = (0..=100).map(|k| factor(&curve, f64::from(k) / 100.0)).collect();
            let mean = values.iter().sum::<f64>() / 101.0;
            sum += values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
            count += 101.0;
        }
        let rms = (sum / count).sqrt();
        assert!((rms / (0.02 * 3.0_f64.sqrt()) - 1.0).abs() < 0.05, "{rms}");
    }
}
