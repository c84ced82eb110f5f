//! `chamber_coupling`: opposite chamber changes the volume.

use crate::effects::{Domain, EffectInfo, EffectParameter, Facing, Hook, Memory, Step, Stretch, Question, Reach, Trait, Structure};
use crate::effects::remembered::Remembered;
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "chamber_coupling",
    title: "Opposite chamber changes the volume",
    physics: "Two chambers bend a joint against each other. When the bending is not measured, the pressure difference of the pair lengthens one chamber and shortens the other, with the swing of the joint.",
    equation: "V = V_0 (1 + coupling x),  x follows p - p_opposite with the joint's frequency and damping",
    source: "antagonistic pair with inertia, bending stiffness and friction",
    question: Question::Structure,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        // Usual: half a percent of the volume per 100 kPa.
        EffectParameter::linear("coupling", "1/(100 kPa)", (-0.3, 0.0, 0.6), "relative growth of the volume per 100 kPa over the chamber opposite").usual_to(0.005).of_load(),
        EffectParameter::logarithmic("frequency", "Hz", (0.2, 1.5, 15.0), "natural frequency of the joint").of_load(),
        EffectParameter::linear("damping", "1", (0.1, 0.7, 3.0), "damping ratio of the joint").of_load(),
    ],
    probes: &[&[0.03, 1.5, 0.6], &[0.03, 6.0, 1.0]],
    rivals: &["sensor_crosstalk", "supply_sag", "wall_compliance"],
    separated_by: "one chamber held with closed ports while the one opposite moves",
    smallest: 0.003,
    traits: &[Trait::NeedsOpposite],
    check: "measure the joint angle, or hold the joint and see whether it vanishes",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct ChamberCoupling<S> {
    coupling: S,
    frequency: S,
    damping: S,
    angle: Remembered<S>,
    rate: Remembered<S>,
}

impl<S: Scalar> ChamberCoupling<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { coupling: values[0], frequency: values[1], damping: values[2], angle: Remembered::nothing(), rate: Remembered::nothing() }
    }
}

impl<S: Scalar> Hook<S> for ChamberCoupling<S> {
    fn structure(&self, structure: &mut Structure<S>) {
        (structure.stretches, structure.faces) = (true, true);
    }

    fn reset(&mut self) {
        (self.angle, self.rate) = (Remembered::nothing(), Remembered::nothing());
    }

    fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        let remembered = [&mut self.angle, &mut self.rate].into_iter();
        remembered.filter_map(Remembered::known).for_each(|value| visit(Memory::Estimated, value));
    }

    #[inline(always)]
    fn stretch(&mut self, step: &Step<'_>, pressures: &Facing<S>, stretch: &mut Stretch<S>) {
        let Some(opposite) = pressures.opposite else {
            return;
        };
        let wanted = (pressures.own - opposite).times(1e-5);
        let (x, v) = (self.angle.or(wanted), self.rate.or(S::zero()));
        // Semi-implicit: stable for any step, and the joint is slow against it.
        let omega = self.frequency.times(std::f64::consts::TAU);
        let h = step.length_s;
        let stiffness = omega.square().times(h);
        let friction = (omega * self.damping).times(2.0 * h);
        let v = (v + stiffness * (wanted - x)) / (friction + stiffness.times(h)).plus(1.0);
        self.angle.set(x + v.times(h));
        self.rate.set(v);
        stretch.factor = stretch.factor + self.coupling * (x + v.times(0.5 * h));
        stretch.rate = stretch.rate + self.coupling * v;
    }
}
