//! What a step gives.

/// Where a saved state has the pressure in the chamber, kPa gauge. Its first number is 0 where the
/// channel was not started.
pub const STATE_PRESSURE: usize = 3;

/// The channel at the end of a step. Pressures are gauge, in kPa.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Outputs {
    /// Time since the start, s.
    pub time_s: f64,
    /// Pressure in the chamber.
    pub pressure_kpa: f64,
    /// Pressure at the valve: another one where there is a tube between them.
    pub port_kpa: f64,
    /// What the board reports.
    pub reading_kpa: f64,
    /// Temperature of the gas, K: ambient, unless the effect heat_exchange is part of the model.
    pub temperature_k: f64,
    /// Position of the spool (-1 to 1) or the fill valve (0 to 1), behind all effects; NaN of a
    /// regulator.
    pub fill: f64,
    /// Position of the vent valve; minus that of the one spool.
    pub vent: f64,
    /// Drive before effects, mean over the step, -1 to 1; fill minus vent where there are two
    /// valves. NaN of a fitted regulator.
    pub drive: f64,
    /// Flow drawn from the supply, mean over the step, mm^2 Pa (area by flow pressure); NaN where
    /// the model was saved by `fit`.
    pub draw: f64,
    /// Rate of the pressure in the chamber, mean over the step, kPa/s.
    pub rate_kpa_s: f64,
}

impl Outputs {
    /// Shows every number of it, in an order that stays.
    pub(crate) fn values(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        let Self {
            time_s,
            pressure_kpa,
            port_kpa,
            reading_kpa,
            temperature_k,
            fill,
            vent,
            drive,
            draw,
            rate_kpa_s,
        } = self;
        [time_s, pressure_kpa, port_kpa, reading_kpa, temperature_k, fill, vent, drive, draw, rate_kpa_s]
            .into_iter()
            .for_each(visit);
    }
}
