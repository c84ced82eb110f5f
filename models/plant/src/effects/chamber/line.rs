//! The gas behind a tube, with a temperature or without.

use super::{Chamber, Conditions, Flows};
use crate::effects::hook::LineParameters;
use crate::effects::tube::{Ends, Tube};
use crate::model::GAMMA;
use crate::numeric::Scalar;

/// A flow that is slow, as a rate of the chamber's pressure, Pa/s: which way it goes hardly
/// matters.
const SLOW_PA_S: f64 = 1e4;

/// No pressure falls below this, Pa: what would take more in a step than there is.
const LOWEST_PA: f64 = 1e3;

impl<S: Scalar> Chamber<S> {
    /// The port's volume and the chamber's, with a tube between them.
    #[inline(always)]
    pub(super) fn advance_line(
        &mut self,
        h: f64,
        c: &Conditions<S>,
        flows: &Flows<S>,
        line: &LineParameters<S>,
    ) {
        let &Flows { fill, vent, inflow, in_by, outflow, out_by } = flows;
        let (mut swelling, mut chamber) = (self.growth(c), S::constant(1.0));
        if self.stretches() {
            let room = c.stretch.factor + (self.pressure * c.stretch.by_pressure).times(GAMMA);
            swelling = swelling / room;
            chamber = room.recip();
        }
        let (driven, slope) = (fill * inflow - vent * outflow, fill * in_by - vent * out_by);
        let ends = Ends { driven, slope, swelling, port: line.volume_ratio.recip(), chamber };
        let tube = Tube { flow: &self.ports.own, line };
        let pressures = [self.port, self.pressure];
        let halfway = tube.halfway(h, &ends, pressures);
        let [port, chamber] = match self.structure.heat_time_constant_s {
            None => tube.advance(h, &ends, pressures, halfway),
            Some(tau) => self.through_with_heat(h, c, ends, line, halfway, tau),
        };
        let lowest = S::constant(LOWEST_PA);
        (self.port, self.pressure) = (port.max(lowest), chamber.max(lowest));
    }

    /// 1 where gas flows from the chamber into the tube, and 0 where it flows the other way.
    /// Between them it is smooth: of a jump, a derivative knows nothing.
    #[inline(always)]
    fn back(&self, line: &LineParameters<S>, halfway: [S; 2]) -> S {
        let flow = Tube { flow: &self.ports.own, line }.flow(halfway);
        (flow / (flow.square().plus(SLOW_PA_S * SLOW_PA_S)).sqrt()).times(-0.5).plus(0.5)
    }

    /// The step where the chamber's gas has a temperature. That in the tube has its walls': a thin
    /// one exchanges heat within milliseconds. What the wall takes within the step of what flows is
    /// taken from the flow, so that a wall that answers at once makes the chamber isothermal.
    #[inline(always)]
    fn through_with_heat(
        &mut self,
        h: f64,
        c: &Conditions<S>,
        ends: Ends<S>,
        line: &LineParameters<S>,
        halfway: [S; 2],
        tau: S,
    ) -> [S; 2] {
        let heat = self.heat(h, c, tau);
        // Energy per flow: only what comes from the chamber is warm.
        let warmth = (heat.warmth.plus(-1.0) * self.back(line, halfway)).plus(1.0);
        let line = LineParameters { time_constant_s: line.time_constant_s * warmth.sqrt(), ..*line };
        let growth = -(self.growth(c) * self.pressure);
        let ends =
            Ends { port: ends.port.times(1.0 / GAMMA), chamber: ends.chamber * heat.kept(warmth), ..ends };
        let tube = Tube { flow: &self.ports.own, line: &line };
        let [port, chamber] = tube.advance(h, &ends, [self.port, self.pressure], halfway);
        let middle = (self.pressure + chamber).times(0.5);
        let flow = ((chamber - self.pressure).times(1.0 / h) + ends.swelling * middle) / ends.chamber;
        self.temperature = heat.end(heat.settled(flow * warmth + growth, flow));
        let taken = heat.taken(heat.settled(growth, S::zero()));
        [port, chamber - heat.rate(taken).times(h)]
    }
}
