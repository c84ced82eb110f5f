//! The shared supply: regulator, tank, line and manifold.

use super::background::FAST_WANDER_S;
use super::noise::{Purpose, Wander, stream, uniform};
use super::physics::{GAS_CONSTANT, RelayRegulator, SupplyLine, SupplyPhysics};

/// Share of a compressor's period in which the pressure rises.
const RIPPLE_RISE: f64 = 0.3;

/// What the supply does by itself.
#[derive(Debug, Clone)]
pub struct Supply {
    pub physics: SupplyPhysics,
    phase: f64,
    wander: Option<Wander>,
    fast_wander: Option<Wander>,
    refilling: bool,
}

/// Source conditions, constant over one integration step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Source {
    /// Absolute pressure at the regulator, Pa.
    pub pressure_pa: f64,
    /// Temperature of the air, K.
    pub temperature_k: f64,
    /// Mass flow into the tank, kg/s (relay regulator only).
    pub refill: f64,
}

impl Supply {
    pub fn new(physics: SupplyPhysics, seed: u64) -> Self {
        let phase = uniform(&mut stream(seed, Purpose::RipplePhase, 0));
        let wander = (physics.wander > 0.0)
            .then(|| Wander::new(stream(seed, Purpose::SupplyWander, 0), physics.wander_time_s));
        let fast_wander = (physics.fast_wander > 0.0)
            .then(|| Wander::new(stream(seed, Purpose::FastWander, 0), FAST_WANDER_S));
        Self { physics, phase, wander, fast_wander, refilling: false }
    }

    /// Conditions for a step whose middle is at `time_s`, with the tank at `tank_pa`.
    pub fn source(&mut self, time_s: f64, ambient_k: f64, tank_pa: f64) -> Source {
        let p = &self.physics;
        let mut pressure = p.nominal_pa + p.level_pa;
        if let Some(wander) = &mut self.wander {
            pressure += p.gauge_pa * p.wander * wander.at(time_s);
        }
        if let Some(wander) = &mut self.fast_wander {
            pressure += p.gauge_pa * p.fast_wander * wander.at(time_s);
        }
        if let Some((amplitude, period)) = p.ripple {
            pressure += amplitude * compressor_cycle(time_s / period + self.phase);
        }
        let mut temperature = ambient_k;
        if let Some((amplitude, period)) = p.temperature_cycle {
            temperature += amplitude * (core::f64::consts::TAU * time_s / period).sin();
        }
        let mut refill = 0.0;
        if let Some(relay) = &p.relay {
            if tank_pa < pressure - relay.half_band_pa {
                self.refilling = true;
            } else if tank_pa > pressure + relay.half_band_pa {
                self.refilling = false;
            }
            refill = if self.refilling { relay.refill_kg_per_s } else { 0.0 };
        }
        Source { pressure_pa: pressure, temperature_k: temperature, refill }
    }
}

/// A charging compressor: -1 to 1 in the first 30 % of the period, back to -1 in the rest.
fn compressor_cycle(periods: f64) -> f64 {
    let phase = periods - periods.floor();
    if phase < RIPPLE_RISE {
        2.0 * phase / RIPPLE_RISE - 1.0
    } else {
        1.0 - 2.0 * (phase - RIPPLE_RISE) / (1.0 - RIPPLE_RISE)
    }
}

impl SupplyLine {
    /// Mass flow, kg/s, for a pressure drop in Pa (the inverse of
    /// `drop = linear m + quadratic m |m|`).
    #[inline]
    pub fn mass_flow(&self, drop_pa: f64) -> f64 {
        // The root without cancellation: 2 d / (l + sqrt(l^2 + 4 q |d|)).
        2.0 * drop_pa
            / (self.linear + (self.linear * self.linear + 4.0 * self.quadratic * drop_pa.abs()).sqrt())
    }

    /// Rate of the manifold's pressure, Pa/s.
    #[inline]
    pub fn rate(&self, upstream_pa: f64, manifold_pa: f64, drawn: f64, temperature_k: f64) -> f64 {
        let inflow = self.mass_flow(upstream_pa - manifold_pa);
        GAS_CONSTANT * temperature_k / self.volume_m3 * (inflow - drawn)
    }
}

impl RelayRegulator {
    /// Rate of the tank's pressure, Pa/s.
    #[inline]
    pub fn rate(&self, refill: f64, drawn: f64, temperature_k: f64) -> f64 {
        GAS_CONSTANT * temperature_k / self.volume_m3 * (refill - drawn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn line_flow_inverts_the_drop() {
        let line = SupplyLine { linear: 2e7, quadratic: 5e9, volume_m3: 1e-4 };
        for m in [-3e-3, 0.0, 1e-5, 2e-3] {
            let drop = line.linear * m + line.quadratic * m * f64::abs(m);
            assert!((line.mass_flow(drop) - m).abs() < 1e-15, "{m}");
        }
    }

    #[test]
    fn compressor_cycle_is_a_lopsided_triangle() {
        assert!((compressor_cycle(0.0) + 1.0).abs() < 1e-12);
        assert!((compressor_cycle(1.3) - 1.0).abs() < 1e-12);
        assert!(compressor_cycle(0.65).abs() < 1e-12);
        assert!(compressor_cycle(0.15).abs() < 1e-12);
    }
}
