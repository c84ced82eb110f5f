//! `[boards.N]` and `[boards.N.channels.K]`: what boards and channels have of their own.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Chamber, Controller, Rig, Sensor, Valve};
use crate::{ChannelId, SensorLimits};

/// Resolution of the converters where a file has calibrations and no `[sensor]`: that of counts on
/// the bus.
const BUS_BITS: u32 = 10;

/// Tables of one board: each takes the place of the rig's, whole.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct OwnOfBoard {
    /// Its chambers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chamber: Option<Chamber>,
    /// Its valves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub valve: Option<Valve>,
    /// Its pressure loop.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub controller: Option<Controller>,
    /// Calibration of its sensors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<Calibration>,
    /// Its channels, by number.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub channels: BTreeMap<u8, OwnOfChannel>,
}

/// Tables of one channel: each takes the place of its board's, whole.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct OwnOfChannel {
    /// Its chamber.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chamber: Option<Chamber>,
    /// Its valve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub valve: Option<Valve>,
    /// Calibration of its sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<Calibration>,
}

/// A sensor's line; the converter is the same for all.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Reading at 0 kPa gauge, counts.
    pub zero_counts: f64,
    /// Size of one count, kPa.
    pub kpa_per_count: f64,
}

impl Rig {
    /// The machine at one channel: of each table the channel's own, else its board's, else that of
    /// all.
    #[must_use]
    pub fn at(&self, id: ChannelId) -> Self {
        let board = self.boards.get(&id.board);
        let channel = board.and_then(|board| board.channels.get(&id.channel));
        let calibration = channel
            .and_then(|own| own.sensor)
            .or_else(|| board.and_then(|own| own.sensor))
            .map(|Calibration { zero_counts, kpa_per_count }| {
                let bits = self.sensor.as_ref().map_or(BUS_BITS, |sensor| sensor.bits);
                Sensor { bits, zero_counts, kpa_per_count }
            });
        let chamber = channel.and_then(|own| own.chamber.clone());
        let valve = channel.and_then(|own| own.valve.clone());
        Self {
            supply: self.supply.clone(),
            ambient: self.ambient.clone(),
            chamber: chamber.or_else(|| board?.chamber.clone()).or_else(|| self.chamber.clone()),
            valve: valve.or_else(|| board?.valve.clone()).or_else(|| self.valve.clone()),
            controller: board.and_then(|own| own.controller).or(self.controller),
            sensor: calibration.or(self.sensor),
            boards: BTreeMap::new(),
            highest_set_point_kpa: self.highest_set_point_kpa,
        }
    }

    /// The pressures beyond which a channel's reading says nothing; none where its sensor is not
    /// described.
    #[must_use]
    pub fn sensor_limits(&self, id: ChannelId) -> Option<SensorLimits> {
        self.at(id).sensor.map(SensorLimits::from)
    }

    /// Drops boards and channels that have nothing of their own: names and limits are not the
    /// toolkit's.
    pub(super) fn keep_own(&mut self) {
        for board in self.boards.values_mut() {
            board.channels.retain(|_, own| *own != OwnOfChannel::default());
        }
        self.boards.retain(|_, own| *own != OwnOfBoard::default());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[chamber]\nvolume_m3 = 1e-4\n[valve]\ncritical_ratio = 0.4\n\
        [controller]\nrate_hz = 1000\nkp = 10\nsaturation = 400\n\
        [boards.0]\nname = \"arm\"\n[boards.1.chamber]\nradius_m = 0.02\nlength_m = 0.1\n\
        [boards.1.controller]\nrate_hz = 500\nkp = 5\nsaturation = 400\n\
        [boards.1.sensor]\nzero_counts = 100\nkpa_per_count = 0.8\n\
        [boards.1.channels.2.chamber]\nvolume_m3 = 3e-4\n\
        [boards.1.channels.2.valve]\ndischarge_coefficient = 0.5\ncritical_ratio = 0.2\n\
        [boards.1.channels.3.sensor]\nzero_counts = 110\nkpa_per_count = 0.9\n";

    fn at(rig: &Rig, board: u8, channel: u8) -> Rig {
        rig.at(ChannelId { board, channel })
    }

    #[test]
    fn the_nearest_table_holds() {
        let rig = Rig::parse("rig.toml", TEXT).unwrap();
        let volume = |b, c| at(&rig, b, c).chamber.unwrap().rest_volume_m3();
        assert_eq!((volume(0, 0), volume(1, 2)), (1e-4, 3e-4));
        assert!((volume(1, 0) - 1.256_637e-4).abs() < 1e-9);
        let ratio = |b, c| at(&rig, b, c).valve.unwrap().critical_ratio;
        assert_eq!((ratio(0, 2), ratio(1, 1), ratio(1, 2)), (0.4, 0.4, 0.2));
        let kp = |b, c| at(&rig, b, c).controller.unwrap().kp;
        assert_eq!((kp(0, 0), kp(1, 2)), (10.0, 5.0));
        let zero = |b, c| at(&rig, b, c).sensor.map(|sensor| (sensor.bits, sensor.zero_counts));
        assert_eq!((zero(0, 0), zero(1, 0), zero(1, 3)), (None, Some((10, 100.0)), Some((10, 110.0))));
        assert_eq!(rig.sensor_limits(ChannelId { board: 1, channel: 3 }).unwrap().low_kpa, -99.0);
        // Once resolved, always the same.
        assert_eq!(at(&at(&rig, 1, 2), 1, 2), at(&rig, 1, 2));
    }

    #[test]
    fn what_is_kept_with_a_fit_is_read_again() {
        let rig = Rig::parse("rig.toml", TEXT).unwrap();
        assert_eq!(rig.boards.keys().collect::<Vec<_>>(), [&1], "board 0 has a name only");
        assert_eq!(Rig::parse("rig.toml", &toml::to_string(&rig).unwrap()).unwrap(), rig);
    }
}
