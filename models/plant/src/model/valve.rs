//! The valve: how its drives open its two ports.

use crate::numeric::Scalar;

/// How the valve is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ValveDrive {
    /// One spool opens the fill port for positive drives and the vent port for negative ones: one
    /// gain.
    #[default]
    Spool,
    /// A fill valve and a vent valve with a drive of 0 to 1 each: two gains.
    Separate,
}

/// The effective areas of the two ports, mm^2.
#[derive(Debug, Clone, Copy)]
pub struct Areas<S> {
    /// Supply to chamber.
    pub fill: S,
    /// Chamber to air.
    pub vent: S,
}

/// The openings' parameters, areas in mm^2; [`Nonlinear`](super::Nonlinear) says what they mean.
#[derive(Debug, Clone, Copy)]
pub struct ValveLaw<S> {
    /// Area the fill port closes to.
    pub leak_in: S,
    /// Area the vent port closes to.
    pub leak_out: S,
    /// Opening of the fill port per unit of drive.
    pub gain_in: S,
    /// Opening of the vent port per unit of drive.
    pub gain_out: S,
    /// Fill drive at which the fill port starts to open.
    pub threshold_in: S,
    /// Vent drive at which the vent port starts to open.
    pub threshold_out: S,
    /// Width of the corners.
    pub corner: S,
}

impl<S: Scalar> ValveLaw<S> {
    /// Areas of the ports at these drives of the fill and the vent port; a spool's drive opens the
    /// vent port when it is negative.
    #[inline(always)]
    pub fn areas(&self, fill: S, vent: S) -> Areas<S> {
        Areas {
            fill: self.area(self.leak_in, self.gain_in, fill - self.threshold_in),
            vent: self.area(self.leak_out, self.gain_out, vent - self.threshold_out),
        }
    }

    #[inline(always)]
    fn area(&self, leak: S, gain: S, opening: S) -> S {
        leak + smooth_corner(gain * opening - leak, self.corner)
    }

    /// Areas of the ports at full drive, without leaks and corners.
    #[inline(always)]
    pub fn open(&self) -> Areas<S> {
        let area = |gain: S, threshold: S| gain * (-threshold).plus(1.0);
        Areas { fill: area(self.gain_in, self.threshold_in), vent: area(self.gain_out, self.threshold_out) }
    }
}

/// `max(x, 0)` with its corner rounded over the width `e`: `(sqrt(x^2 + e^2) + x) / 2`.
///
/// The paper prints `e = 1`, which adds half a unit of whatever `x` is measured in; here the width
/// is a parameter in the unit of `x`.
#[inline(always)]
pub fn smooth_corner<S: Scalar>(x: S, width: S) -> S {
    ((x.square() + width.square()).sqrt() + x).times(0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corner_is_half_its_width_high_and_dies_out() {
        assert_eq!(smooth_corner(0.0, 0.2), 0.1);
        assert!((smooth_corner(10.0, 0.1) - 10.000_25).abs() < 1e-8);
        assert!((smooth_corner(-10.0, 0.1) - 0.000_25).abs() < 1e-8);
    }

    #[test]
    fn a_sharp_valve_opens_by_its_gain_beyond_its_threshold_and_leaks_below() {
        let law = ValveLaw {
            leak_in: 0.01,
            leak_out: 0.02,
            gain_in: 4.0,
            gain_out: 2.0,
            threshold_in: 0.1,
            threshold_out: 0.2,
            corner: 0.0,
        };
        let filling = law.areas(0.6, -0.6);
        assert!((filling.fill - 2.0).abs() < 1e-12 && (filling.vent - 0.02).abs() < 1e-12, "{filling:?}");
        let venting = law.areas(-0.7, 0.7);
        assert!((venting.fill - 0.01).abs() < 1e-12 && (venting.vent - 1.0).abs() < 1e-12, "{venting:?}");
        let open = law.open();
        assert!((open.fill - 3.6).abs() < 1e-12 && (open.vent - 1.6).abs() < 1e-12, "{open:?}");
    }
}
