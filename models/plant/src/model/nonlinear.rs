//! The first-principles model: two valve openings, mass balance, changing volume.

use super::{
    About, Areas, Constants, Drive, FlowForm, FlowFunction, GAMMA, Gas, Listed, Model, Parameter, ValveDrive, ValveLaw, column,
};
use crate::numeric::Scalar;

/// `dp/dt = gamma R T / V (m_in - m_out) - gamma w V' p / V`, with the mass flows of
/// [`FlowFunction`] and
///
/// * `A_in = L_in + smax(B (fill - U_in) - L_in)`;
/// * `A_out = L_out + smax(B (U_out - u) - L_out)` of a spool,
///   `L_out + smax(B_out (vent - U_out) - L_out)` of a valve of its own,
///
/// where `smax` is [`smooth_corner`](super::smooth_corner) with the fitted width `e`. `L` is the
/// area a port closes to (the fitted value of the closed port is `L + smax(-L)`, a little more),
/// and `U` is where the opening would start without the corner, not the drive of zero flow. Only
/// the products of areas with the discharge coefficient can be identified, so that coefficient is
/// fixed. `w` weighs the work of the volume's change, not the volume itself.
///
/// Reads the drives and the columns [`SUPPLY_PA`](column::SUPPLY_PA),
/// [`INVERSE_VOLUME_PER_M3`](column::INVERSE_VOLUME_PER_M3) and
/// [`VOLUME_RATE_M3_S`](column::VOLUME_RATE_M3_S).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nonlinear {
    /// The gas and its ambient pressure.
    pub gas: Gas,
    /// The ports' flow function.
    pub flow: FlowFunction,
    /// Discharge coefficient `C_d`, fixed.
    pub discharge_coefficient: f64,
    /// One spool or two valves.
    pub drive: ValveDrive,
}

impl Default for Nonlinear {
    /// A spool valve with the critical ratio 0.3 and the standard's flow function.
    fn default() -> Self {
        Self {
            gas: Gas::default(),
            flow: FlowFunction::new(0.3, FlowForm::Iso6358),
            discharge_coefficient: 1.0,
            drive: ValveDrive::Spool,
        }
    }
}

/// What the parameters say.
#[derive(Debug, Clone, Copy)]
pub struct NonlinearCoefficients<S> {
    /// The valve.
    pub valve: ValveLaw<S>,
    /// Weight of the volume's rate.
    pub volume_weight: S,
}

/// One interval: conductances of the ports and the relative rate of the volume.
#[derive(Debug, Clone, Copy)]
pub struct Interval<S: Scalar> {
    /// Rate of pressure per mean of drops, 1/s.
    fill: S,
    /// Rate of pressure per mean of drops, 1/s.
    vent: S,
    /// `gamma w V' / V`, 1/s.
    expansion: S,
    /// Supply pressure, Pa.
    supply: S::Real,
}

impl Nonlinear {
    /// Factor from an area in mm^2 by a volume in m^3 to a rate of pressure per flow pressure,
    /// m^3/(mm^2 s).
    #[must_use]
    pub fn conductance(&self) -> f64 {
        self.gas.filling_speed() * self.discharge_coefficient * 1e-6
    }
}

impl Listed for Nonlinear {
    const ABOUT: About =
        About { id: "nonlinear", title: "Valve and chamber from first principles", is_regulator: false };

    fn of(constants: &Constants) -> Self {
        let Constants { gas, flow, discharge_coefficient, drive } = *constants;
        Self { gas, flow, discharge_coefficient, drive }
    }
}

impl Model for Nonlinear {
    type Coefficients<S: Scalar> = NonlinearCoefficients<S>;
    type Held<S: Scalar> = Interval<S>;

    fn name(&self) -> &'static str {
        Self::ABOUT.id
    }

    fn parameters(&self) -> Vec<Parameter> {
        let linear = Parameter::linear;
        let log = Parameter::logarithmic;
        let gain = (1e-2, 2.0, 1e3);
        let mut list = vec![
            linear("leak_in", "mm2", (0.0, 0.02, 20.0), "area the fill port closes to"),
            linear("leak_out", "mm2", (0.0, 0.02, 20.0), "area the vent port closes to"),
        ];
        match self.drive {
            ValveDrive::Spool => list.extend([
                log("gain", "mm2", gain, "opening per unit of drive"),
                linear("threshold_in", "1", (-1.0, 0.0, 1.0), "drive at which the fill port opens"),
                linear("threshold_out", "1", (-1.0, 0.0, 1.0), "drive below which the vent port opens"),
            ]),
            ValveDrive::Separate => list.extend([
                log("gain_in", "mm2", gain, "opening of the fill valve per unit of its drive"),
                log("gain_out", "mm2", gain, "opening of the vent valve per unit of its drive"),
                linear("threshold_in", "1", (-1.0, 0.0, 1.0), "fill drive at which the fill valve opens"),
                linear("threshold_out", "1", (-1.0, 0.0, 1.0), "vent drive at which the vent valve opens"),
            ]),
        }
        list.extend([
            log("corner", "mm2", (1e-4, 0.1, 10.0), "width over which the valve's corner is rounded"),
            linear("volume_weight", "1", (0.0, 1.0, 3.0), "weight of the volume's rate"),
        ]);
        list
    }

    #[inline(always)]
    fn coefficients<S: Scalar>(&self, p: &[S]) -> NonlinearCoefficients<S> {
        // Where one spool opens both ports they share the gain, and the vent port opens on the
        // other side.
        let [gain_in, gain_out, threshold_in, threshold_out, corner, volume_weight] = match self.drive {
            ValveDrive::Spool => [p[2], p[2], p[3], -p[4], p[5], p[6]],
            ValveDrive::Separate => [p[2], p[3], p[4], p[5], p[6], p[7]],
        };
        let (leak_in, leak_out) = (p[0], p[1]);
        let valve = ValveLaw { leak_in, leak_out, gain_in, gain_out, threshold_in, threshold_out, corner };
        NonlinearCoefficients { valve, volume_weight }
    }

    #[inline(always)]
    fn hold<S: Scalar>(&self, c: &NonlinearCoefficients<S>, row: &[S::Real], drive: Drive<S>) -> Interval<S> {
        let Areas { fill, vent } = c.valve.areas(drive.fill, drive.vent);
        let inverse_volume = row[column::INVERSE_VOLUME_PER_M3];
        let conductance = inverse_volume.times(self.conductance() * self.flow.gain());
        let expansion = (row[column::VOLUME_RATE_M3_S] * inverse_volume).times(GAMMA);
        Interval {
            fill: fill.scale(conductance),
            vent: vent.scale(conductance),
            expansion: c.volume_weight.scale(expansion),
            supply: row[column::SUPPLY_PA],
        }
    }

    #[inline(always)]
    fn rate<S: Scalar>(&self, _: &NonlinearCoefficients<S>, held: &Interval<S>, pressure: S) -> S {
        let inflow = self.flow.mean_from(held.supply, pressure);
        let outflow = self.flow.mean_to(pressure, S::Real::constant(self.gas.ambient_pa));
        held.fill * inflow - held.vent * outflow - held.expansion * pressure
    }
}
