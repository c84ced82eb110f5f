//! The parametric model after Tassa, Wu, Movellan and Todorov (2013): a first-order lag whose end
//! point and rate depend on the drive and on the volume.

use super::{About, Constants, Drive, Gas, Listed, Model, Parameter, ValveDrive, column, smooth_corner};
use crate::numeric::Scalar;

/// Cubic metres in a litre: volumes enter this model in litres, so that its coefficients are of
/// order one.
const LITRE_M3: f64 = 1e-3;

/// Width in 1/s over which the rate is rounded off above zero.
const RATE_CORNER_PER_S: f64 = 0.01;

/// `dp/dt = (s - p) r` with, for the drive `u`, the volume `V` and its rate `V'`:
///
/// * `x = u - c1`;
/// * end point `s = c_b + c_s g(c2 x + c3 x^3) + c4 V'`, `g(y) = y / sqrt(y^2 + 1)`;
/// * rate `r = (c7 k + c5 V') / (1 + c6 V)`, `k = sqrt(x^2 + c_gamma^2) - c_gamma + c8 x + c9`.
///
/// The paper leaves `g` and `k` open; these are the ones its laboratory uses. Three repairs make it
/// usable: `c_b` and `c_s` are not fitted but the middle and half of the range from ambient to
/// supply pressure; `c6 >= 0`, so that the pole lies outside; and the rate is kept positive by
/// [`smooth_corner`]. Positive coefficients are fitted by their logarithms.
///
/// Reads the drives and the columns [`SUPPLY_PA`](column::SUPPLY_PA),
/// [`INVERSE_VOLUME_PER_M3`](column::INVERSE_VOLUME_PER_M3) and
/// [`VOLUME_RATE_M3_S`](column::VOLUME_RATE_M3_S).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Parametric {
    /// Ambient pressure is taken from here.
    pub gas: Gas,
    /// How the two drive columns make one drive `u`: a spool's `u` is in both, of two valves it is
    /// the difference.
    pub drive: ValveDrive,
}

/// The coefficients by their numbers in the paper.
#[derive(Debug, Clone, Copy)]
pub struct Numbers<S> {
    c1: S,
    c2: S,
    c3: S,
    /// Pa s/l.
    c4: S,
    c5: S,
    c6: S,
    c7: S,
    c8: S,
    c9: S,
    gamma: S,
}

/// Where the pressure goes (Pa) and how fast (1/s).
#[derive(Debug, Clone, Copy)]
pub struct Course<S> {
    end: S,
    rate: S,
}

impl Listed for Parametric {
    const ABOUT: About =
        About { id: "parametric", title: "Tassa et al. 2013", is_regulator: false };

    fn of(constants: &Constants) -> Self {
        Self { gas: constants.gas, drive: constants.drive }
    }
}

impl Model for Parametric {
    type Coefficients<S: Scalar> = Numbers<S>;
    type Held<S: Scalar> = Course<S>;

    fn name(&self) -> &'static str {
        Self::ABOUT.id
    }

    fn parameters(&self) -> Vec<Parameter> {
        let linear = Parameter::linear;
        let log = Parameter::logarithmic;
        vec![
            linear("c1", "1", (-1.0, 0.0, 1.0), "drive of the middle position"),
            log("c2", "1", (1e-2, 3.0, 1e3), "slope of the end pressure with the drive"),
            linear("c3", "1", (0.0, 1.0, 1e4), "cubic part of the end pressure"),
            linear("c4", "kPa s/l", (-1e3, 0.0, 1e3), "end pressure by rate of volume"),
            linear("c5", "1/l", (-1e3, 0.0, 1e3), "rate by rate of volume"),
            linear("c6", "1/l", (0.0, 1.0, 1e3), "rate falls with volume"),
            log("c7", "1/s", (1e-2, 10.0, 1e4), "rate per opening"),
            linear("c8", "1", (-0.99, 0.0, 0.99), "asymmetry of the opening"),
            log("c9", "1", (1e-5, 0.02, 1.0), "opening that is always there"),
            log("c_gamma", "1", (1e-4, 0.1, 1.0), "width of the opening's corner"),
        ]
    }

    #[inline(always)]
    fn coefficients<S: Scalar>(&self, p: &[S]) -> Numbers<S> {
        Numbers {
            c1: p[0],
            c2: p[1],
            c3: p[2],
            c4: p[3].times(1e3),
            c5: p[4],
            c6: p[5],
            c7: p[6],
            c8: p[7],
            c9: p[8],
            gamma: p[9],
        }
    }

    #[inline(always)]
    fn hold<S: Scalar>(&self, c: &Numbers<S>, row: &[S::Real], drive: Drive<S>) -> Course<S> {
        let difference = drive.fill - drive.vent;
        let u = match self.drive {
            ValveDrive::Spool => difference.times(0.5),
            ValveDrive::Separate => difference,
        };
        let x = u - c.c1;
        let y = (c.c2 + c.c3 * x.square()) * x;
        let g = y / y.square().plus(1.0).sqrt();
        let volume = row[column::INVERSE_VOLUME_PER_M3].times(LITRE_M3).recip();
        let volume_rate = row[column::VOLUME_RATE_M3_S].times(1.0 / LITRE_M3);
        let supply = row[column::SUPPLY_PA];
        let half_range = supply.plus(-self.gas.ambient_pa).times(0.5);
        let middle = supply.plus(self.gas.ambient_pa).times(0.5);

        let k = (x.square() + c.gamma.square()).sqrt() - c.gamma + c.c8 * x + c.c9;
        let rate = (c.c7 * k + c.c5.scale(volume_rate)) / c.c6.scale(volume).plus(1.0);
        Course {
            end: g.scale(half_range).shift(middle) + c.c4.scale(volume_rate),
            rate: smooth_corner(rate, S::constant(RATE_CORNER_PER_S)),
        }
    }

    #[inline(always)]
    fn rate<S: Scalar>(&self, _: &Numbers<S>, held: &Course<S>, pressure: S) -> S {
        (held.end - pressure) * held.rate
    }
}
