//! A recording seen through the rig file: the inputs and measurements of one chamber as the
//! rollouts take them.

use std::ops::Range;

use crate::input_error::SHORTEST_STRETCH_ROWS;
use crate::rig::{Rig, RigError};
use crate::{Channel, ChannelId, Drive, InputError, Recording};
use pneudrive_plant::model::column;
use pneudrive_plant::rollout::Series;

const PA_PER_KPA: f64 = 1e3;

/// What a simulation of a channel needs to know.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Needs {
    /// The commanded pressure (linear model, board's controller).
    pub command: bool,
    /// The valve's drive.
    pub drive: bool,
    /// Supply pressure and chamber volume.
    pub pneumatics: bool,
    /// Measured pressures to compare with and to start from.
    pub pressure: bool,
    /// Without measured pressures: pressure at the start of every stretch, kPa gauge.
    pub start_kpa: f64,
    /// Combine separate fill and vent drives to the drive of one spool, their difference.
    pub as_spool: bool,
}

/// The inputs of `channel` over the given rows of `recording`, with the stretches among them as
/// segments. Row 0 of the series is the first of `rows`.
///
/// Pressures are absolute and in Pa. Supply and volume are means over each interval, the volume's
/// rate is its change over the interval. A row's measurement has weight 1 where it may be compared
/// and 0 where it is masked.
///
/// # Errors
/// [`InputError`] when the recording or the rig lacks what `needs` asks for.
pub fn series(
    recording: &Recording,
    channel: &Channel,
    rig: &Rig,
    needs: Needs,
    rows: Range<usize>,
) -> Result<Series, InputError> {
    let file = &recording.source.file;
    let id = channel.id;
    let ambient_pa = rig.ambient_or_standard().pressure_kpa_abs * PA_PER_KPA;
    if needs.command {
        recording.command(channel, "a simulation without a recorded drive (b{n}_u{k})")?;
    }
    if needs.drive && channel.drive.is_none() {
        let (fill, vent) = id.fill_vent_columns();
        return Err(InputError::NoDrive {
            file: file.clone(),
            channel: id,
            spool: id.drive_column(),
            fill,
            vent,
        });
    }
    if needs.pressure {
        recording.pressure(channel, "the comparison with the simulation")?;
    }
    let supply = Supply::of(recording, id, rig, ambient_pa, needs)?;
    let volume = Volume::of(recording, &rig.at(id), id, needs)?;
    let count = recording.rows();
    let mut table = Vec::with_capacity(rows.len() * column::COUNT);
    for row in rows.clone() {
        let next = (row + 1).min(count - 1);
        let interval =
            if next > row { recording.time_s[next] - recording.time_s[row] } else { recording.period_s };
        let (fill, vent) = match &channel.drive {
            Some(Drive::Spool(u)) => (f64::from(u[row]), -f64::from(u[row])),
            Some(Drive::Separate { fill, vent }) if needs.as_spool => {
                let u = f64::from(fill[row]) - f64::from(vent[row]);
                (u, -u)
            }
            Some(Drive::Separate { fill, vent }) => (f64::from(fill[row]), f64::from(vent[row])),
            None => (0.0, 0.0),
        };
        let command = channel.command_kpa.as_ref().map_or(0.0, |c| f64::from(c[row]));
        let (here, there) = (volume.at(row), volume.at(next));
        let mut values = [0.0; column::COUNT];
        values[column::TIME_S] = recording.time_s[row];
        values[column::INTERVAL_S] = interval;
        values[column::FILL] = fill;
        values[column::VENT] = vent;
        values[column::COMMAND_PA] = ambient_pa + PA_PER_KPA * command;
        values[column::SUPPLY_PA] = 0.5 * (supply.at(row) + supply.at(next));
        values[column::INVERSE_VOLUME_PER_M3] = 2.0 / (here + there);
        values[column::VOLUME_RATE_M3_S] = (there - here) / interval;
        table.extend(values);
    }
    let pressure = channel.pressure_kpa.as_deref();
    let gauge_pa = |kpa: f64| ambient_pa + PA_PER_KPA * kpa;
    let mut measured: Vec<f64> =
        rows.clone().map(|row| pressure.map_or(f64::NAN, |p| gauge_pa(f64::from(p[row])))).collect();
    let usable = |row: usize| needs.pressure && pressure.is_some() && channel.flags[row].pressure_usable();
    let mut weights: Vec<f64> = rows.clone().map(|row| f64::from(u8::from(usable(row)))).collect();
    let segments = stretches(recording, channel, &rows, needs.pressure);
    if segments.is_empty() {
        let line = |row: usize| recording.line[row.min(count - 1)];
        return Err(InputError::NothingUsable {
            file: file.clone(),
            channel: id,
            first_row: line(rows.start),
            last_row: line(rows.end.saturating_sub(1)),
        });
    }
    volume.check(recording, id, &segments)?;
    let segments: Vec<Range<usize>> =
        segments.into_iter().map(|s| s.start - rows.start..s.end - rows.start).collect();
    if !needs.pressure {
        for stretch in &segments {
            (measured[stretch.start], weights[stretch.start]) = (gauge_pa(needs.start_kpa), 1.0);
        }
    }
    Series::new(column::COUNT, table, measured, weights, segments).map_err(|source| InputError::Series {
        file: file.clone(),
        channel: id,
        source,
    })
}

/// The simulated stretches: each begins at a usable measurement where measurements are needed.
fn stretches(
    recording: &Recording,
    channel: &Channel,
    rows: &Range<usize>,
    measured: bool,
) -> Vec<Range<usize>> {
    let usable = |row: &usize| !measured || channel.flags[*row].pressure_usable();
    let inside = |range: Range<usize>| {
        let range = range.start.max(rows.start)..range.end.min(rows.end);
        let start = range.clone().find(usable)?;
        Some(start..range.end).filter(|r| r.len() >= SHORTEST_STRETCH_ROWS)
    };
    recording.channel_segments(channel).into_iter().filter_map(inside).collect()
}

/// Supply pressure, absolute, Pa.
enum Supply<'a> {
    Nominal(f64),
    Measured { gauge_kpa: &'a [f32], ambient_pa: f64, nominal_pa: f64 },
}

impl<'a> Supply<'a> {
    fn of(
        recording: &'a Recording,
        id: ChannelId,
        rig: &Rig,
        ambient_pa: f64,
        needs: Needs,
    ) -> Result<Self, InputError> {
        let nominal = rig.supply.as_ref().map(|s| ambient_pa + PA_PER_KPA * s.pressure_kpa);
        match (recording.supply_of(id.board), nominal) {
            (Some(gauge_kpa), _) => {
                Ok(Self::Measured { gauge_kpa, ambient_pa, nominal_pa: nominal.unwrap_or(ambient_pa) })
            }
            (None, Some(pressure)) => Ok(Self::Nominal(pressure)),
            (None, None) if needs.pneumatics => Err(RigError::MissingTable {
                table: "supply",
                purpose: "a model of the valve, unless the recording has a column supply_kpa",
            }
            .into()),
            (None, None) => Ok(Self::Nominal(ambient_pa)),
        }
    }

    fn at(&self, row: usize) -> f64 {
        match self {
            Self::Nominal(pressure) => *pressure,
            Self::Measured { gauge_kpa, ambient_pa, nominal_pa } => {
                let gauge = f64::from(gauge_kpa[row]);
                // Missing for long: no segment covers the row, but the table must hold a number.
                if gauge.is_nan() { *nominal_pa } else { ambient_pa + PA_PER_KPA * gauge }
            }
        }
    }
}

/// Volume of a chamber, m^3.
struct Volume<'a> {
    rest_m3: f64,
    per_rad_m3: f64,
    angle: Option<(&'a [f32], f64)>,
}

impl<'a> Volume<'a> {
    fn of(recording: &'a Recording, rig: &Rig, id: ChannelId, needs: Needs) -> Result<Self, InputError> {
        match &rig.chamber {
            Some(chamber) => Ok(Self {
                rest_m3: chamber.rest_volume_m3(),
                per_rad_m3: chamber.volume_per_rad_m3(),
                angle: recording.joint_angle(id),
            }),
            None if needs.pneumatics => {
                Err(RigError::MissingTable { table: "chamber", purpose: "a model of the valve and chamber" }
                    .into())
            }
            None => Ok(Self { rest_m3: 1.0, per_rad_m3: 0.0, angle: None }),
        }
    }

    fn at(&self, row: usize) -> f64 {
        let Some((angle, sign)) = self.angle else { return self.rest_m3 };
        let q = f64::from(angle[row]);
        // As for the supply: a row without an angle is in no segment.
        if q.is_nan() { self.rest_m3 } else { self.rest_m3 + sign * self.per_rad_m3 * q }
    }

    fn check(
        &self,
        recording: &Recording,
        id: ChannelId,
        segments: &[Range<usize>],
    ) -> Result<(), InputError> {
        let Some((angle, _)) = self.angle else { return Ok(()) };
        // Five per cent: an empty chamber is no chamber, and the model divides by the volume.
        let least = 0.05 * self.rest_m3;
        match segments.iter().flat_map(Clone::clone).find(|row| self.at(*row) < least) {
            None => Ok(()),
            Some(row) => Err(InputError::NoVolume {
                file: recording.source.file.clone(),
                row: recording.line[row],
                channel: id,
                angle_rad: f64::from(angle[row]),
                volume_ml: 1e6 * self.at(row),
            }),
        }
    }
}
