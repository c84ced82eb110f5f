//! What the channels of a recording have in common: held once, however many there are.

use std::sync::Arc;

use crate::data::{Flags, Recording};
use crate::diagnosis::channel::Pressures;
use crate::effects::Series;
use crate::rig::Rig;

/// Volume of a rig that gives none, m^3: only its product with the openings matters.
const VOLUME_M3: f64 = 1e-4;

/// Inputs of every channel of a recording.
pub struct Common {
    /// Time from the start of the recording, s.
    pub time_s: Series,
    /// Length of the interval to the next row, s.
    pub interval_s: Series,
    /// Rows at which all simulations start anew.
    pub starts: Arc<[usize]>,
    /// Recorded supply pressure, or the rig file's, Pa; none where neither says anything.
    supply_pa: Option<Series>,
    /// The same of boards that measure it themselves.
    board_supplies_pa: Vec<(u8, Series)>,
    /// Ambient pressure, row by row, Pa.
    pub ambient_pa: Series,
    /// Volume of a chamber at rest, row by row, m^3: of those without a description of their own.
    usual_rest_m3: Series,
    /// Nothing, row by row.
    pub zeros: Series,
    /// Pressures of all channels.
    pub pressures: Pressures,
}

impl Common {
    /// Of a recording; channels without measured pressures stay at `unmeasured_kpa`.
    pub fn new(recording: &Recording, rig: &Rig, unmeasured_kpa: Option<f64>) -> Self {
        let rows = recording.rows();
        let every = |value: f64| -> Series { vec![value; rows].into() };
        let ambient_pa = rig.ambient_or_standard().pressure_kpa_abs * 1e3;
        let origin = recording.time_s.first().copied().unwrap_or(0.0);
        let absolute = |kpa: &[f32]| -> Series { to_f64(kpa).iter().map(|p| p * 1e3 + ambient_pa).collect() };
        let board_supplies_pa =
            recording.board_supplies.iter().map(|own| (own.board, absolute(&own.kpa))).collect();
        let supply_pa = match (&recording.supply_kpa, &rig.supply) {
            (Some(measured), _) => Some(absolute(measured)),
            (None, Some(supply)) => Some(every(supply.pressure_kpa * 1e3 + ambient_pa)),
            (None, None) => None,
        };
        Self {
            time_s: recording.time_s.iter().map(|t| t - origin).collect(),
            interval_s: intervals(recording),
            starts: starts(recording).into(),
            supply_pa,
            board_supplies_pa,
            ambient_pa: every(ambient_pa),
            usual_rest_m3: every(rest_volume_m3(rig)),
            zeros: every(0.0),
            pressures: Pressures::measured(recording, unmeasured_kpa),
        }
    }

    /// Supply pressure for the channels of `board`, Pa: measured by itself, measured for the rig,
    /// or the rig file's.
    pub fn supply_pa(&self, board: u8) -> Option<&Series> {
        let own = self.board_supplies_pa.iter().find(|(of, _)| *of == board);
        own.map(|(_, series)| series).or(self.supply_pa.as_ref())
    }

    /// Volume at rest, row by row, m^3, of a channel with this rig; one series for all channels
    /// with the usual one.
    pub fn rest_m3(&self, rig: &Rig) -> Series {
        let volume = rest_volume_m3(rig);
        match self.usual_rest_m3.first() {
            Some(usual) if usual.total_cmp(&volume).is_eq() => self.usual_rest_m3.clone(),
            _ => vec![volume; self.usual_rest_m3.len()].into(),
        }
    }
}

/// Volume of the chamber at rest, m^3.
fn rest_volume_m3(rig: &Rig) -> f64 {
    rig.chamber.as_ref().map_or(VOLUME_M3, |chamber| chamber.rest_volume_m3())
}

/// Rows at which all simulations start anew: after missing time, and where an input is there again.
fn starts(recording: &Recording) -> Vec<usize> {
    let missing = |row: usize| recording.channels.iter().any(|c| c.flags[row].contains(Flags::INPUT_MISSING));
    let back = (1..recording.rows()).filter(|&row| missing(row - 1) && !missing(row));
    let mut starts: Vec<usize> =
        std::iter::once(0).chain(recording.breaks.iter().copied()).chain(back).collect();
    starts.sort_unstable();
    starts.dedup();
    starts
}

/// Lengths of all intervals, s.
fn intervals(recording: &Recording) -> Series {
    let length = |k: usize| match recording.time_s.get(k + 1) {
        Some(next) if !recording.breaks.contains(&(k + 1)) => next - recording.time_s[k],
        _ => recording.period_s,
    };
    (0..recording.rows()).map(length).collect()
}

/// The values; where one is missing, the one before (no row there is compared).
pub fn to_f64(values: &[f32]) -> Series {
    let mut last = values.iter().copied().find(|v| v.is_finite()).map_or(0.0, f64::from);
    let hold = |v: &f32| {
        if v.is_finite() {
            last = f64::from(*v);
        }
        last
    };
    values.iter().map(hold).collect()
}
