//! The first-principles model: two valve openings, mass balance, changing volume.

use super::{Drive, FlowForm, FlowFunction, GAMMA, Gas, Model, Parameter, column, smooth_corner};
use crate::numeric::Scalar;

/// How the valve is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ValveDrive {
    /// One spool opens the fill port for positive drives and the vent port for negative ones: one gain.
    #[default]
    Spool,
    /// A fill valve and a vent valve with a drive of 0 to 1 each: two gains.
    Separate,
}

/// `dp/dt = gamma R T / V (m_in - m_out) - gamma w V' p / V`, with the mass flows of [`FlowFunction`] and
///
/// * `A_in = L_in + smax(B (fill - U_in) - L_in)`;
/// * `A_out = L_out + smax(B (U_out - u) - L_out)` of a spool, `L_out + smax(B_out (vent - U_out) - L_out)` of a valve of its own,
///
/// where `smax` is [`smooth_corner`] with the fitted width `e`. `L` is the area a port closes to (the fitted value of the
/// closed port is `L + smax(-L)`, a little more), and `U` is where the opening would start without the corner, not the drive of
/// zero flow. Only the products of areas with the discharge coefficient can be identified, so that coefficient is fixed.
/// `w` weighs the work of the volume's change, not the volume itself.
///
/// Reads the drives and the columns [`SUPPLY_PA`](column::SUPPLY_PA), [`INVERSE_VOLUME_PER_M3`](column::INVERSE_VOLUME_PER_M3) and [`VOLUME_RATE_M3_S`](column::VOLUME_RATE_M3_S).
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

/// The openings' parameters, areas in mm^2.
#[derive(Debug, Clone, Copy)]
pub struct Openings<S> {
    leak_in: S,
    leak_out: S,
    gain_in: S,
    gain_out: S,
    threshold_in: S,
    /// Vent drive at which the vent port starts to open.
    threshold_out: S,
    corner: S,
    /// Weight of the volume's rate.
    pub volume_weight: S,
}

impl<S: Scalar> Openings<S> {
    /// Effective areas of the fill and the vent port, mm^2.
    #[inline(always)]
    pub fn areas_mm2(&self, drive: Drive<S>) -> [S; 2] {
        [
            self.area(self.leak_in, self.gain_in, drive.fill - self.threshold_in),
            self.area(self.leak_out, self.gain_out, drive.vent - self.threshold_out),
        ]
    }

    #[inline(always)]
    fn area(&self, leak: S, gain: S, opening: S) -> S {
        leak + smooth_corner(gain * opening - leak, self.corner)
    }
}

/// One interval: conductances of the ports and the relative rate of the volume.
#[derive(Debug, Clone, Copy)]
pub struct Ports<S: Scalar> {
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
    /// Factor from an area in mm^2 by a volume in m^3 to a rate of pressure per flow pressure, m^3/(mm^2 s).
    #[must_use]
    pub fn conductance(&self) -> f64 {
        self.gas.filling_speed() * self.discharge_coefficient * 1e-6
    }
}

impl Model for Nonlinear {
    type Coefficients<S: Scalar> = Openings<S>;
    type Held<S: Scalar> = Ports<S>;

    fn name(&self) -> &'static str {
        "nonlinear"
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
    fn coefficients<S: Scalar>(&self, p: &[S]) -> Openings<S> {
        let (leak_in, leak_out) = (p[0], p[1]);
        match self.drive {
            ValveDrive::Spool => Openings {
                leak_in,
                leak_out,
                gain_in: p[2],
                gain_out: p[2],
                threshold_in: p[3],
                threshold_out: -p[4],
                corner: p[5],
                volume_weight: p[6],
            },
            ValveDrive::Separate => Openings {
                leak_in,
                leak_out,
                gain_in: p[2],
                gain_out: p[3],
                threshold_in: p[4],
                threshold_out: p[5],
                corner: p[6],
                volume_weight: p[7],
            },
        }
    }

    #[inline(always)]
    fn hold<S: Scalar>(&self, c: &Openings<S>, row: &[S::Real], drive: Drive<S>) -> Ports<S> {
        let [fill_mm2, vent_mm2] = c.areas_mm2(drive);
        let inverse_volume = row[column::INVERSE_VOLUME_PER_M3];
        let conductance = inverse_volume.times(self.conductance() * self.flow.gain());
        let expansion = (row[column::VOLUME_RATE_M3_S] * inverse_volume).times(GAMMA);
        Ports {
            fill: fill_mm2.scale(conductance),
            vent: vent_mm2.scale(conductance),
            expansion: c.volume_weight.scale(expansion),
            supply: row[column::SUPPLY_PA],
        }
    }

    #[inline(always)]
    fn rate<S: Scalar>(&self, _: &Openings<S>, held: &Ports<S>, pressure: S) -> S {
        let inflow = self.flow.mean_from(held.supply, pressure);
        let outflow = self.flow.mean_to(pressure, S::Real::constant(self.gas.ambient_pa));
        held.fill * inflow - held.vent * outflow - held.expansion * pressure
    }
}
