//! What to record.

use crate::plant::{Effect, PlantParameters};
use pneudrive_control::BoardConfig;

use super::error::RecordError;
use super::excitation::Excitation;

/// A recording.
#[derive(Debug, Clone)]
pub struct RecordingSettings {
    /// The rig.
    pub plant: PlantParameters,
    /// Effects switched on in it.
    pub effects: Vec<Effect>,
    /// Seed of everything random: excitation, noise, spread, wander.
    pub seed: u64,
    /// Length, s, up to 100 000. There are `seconds * rate_hz` rows, the first at `t_s = 0`.
    pub seconds: f64,
    /// Rows a second, 1 to 1000.
    pub rate_hz: f64,
    /// What the set points do.
    pub excitation: Excitation,
    /// Lowest and highest set point, kPa gauge.
    pub range_kpa: [f64; 2],
    /// Where the loop is closed.
    pub control_loop: Loop,
    /// Who runs the control law when the loop is closed on the board.
    pub board: BoardKind,
    /// The control law.
    pub control: ControlSettings,
    /// Optional columns.
    pub columns: Columns,
    /// Record the true port pressure instead of the sensor's counts. The control loop goes on using
    /// the sensor.
    pub exact: bool,
}

/// Where the loop is closed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Loop {
    /// On the board, at the controller's rate; the host only sends set points.
    ///
    /// `age` is how old the answered measurement is at an exchange, in board loops, 0 to less than
    /// 1: board and host share no clock, so a real one is anywhere in between. The command acts
    /// `1 - age` loops after the exchange: between the answered measurement and the first drive
    /// that knows the command there is always one board loop.
    Board {
        /// Age of the answered measurement, in board loops.
        age: f64,
    },
    /// Once a row: the drive is computed from the row's command and pressure and held until the
    /// next row. With the column `u` the plant alone can be simulated from such a recording. The
    /// law is the ideal one.
    Row,
    /// Nowhere: random drives up to an amplitude are held for 0.05 to 0.8 s, with the sign that
    /// leads back where the pressure has left the range. There are no set points, and no columns
    /// for them.
    Open {
        /// Largest drive, 0 to 1.
        amplitude: f64,
    },
}

/// Who runs the control law.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum BoardKind {
    /// The control crate, as in the firmware: integers, 12-bit samples, PWM steps.
    Firmware,
    /// The same law without integers, on samples rounded to 10 bits.
    Ideal,
}

/// The board's control law in 10-bit counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlSettings {
    /// Loops a second, 50 to 20 000 (ignored when the loop is closed once a row).
    pub rate_hz: f64,
    /// Drive counts per pressure count.
    pub kp: f64,
    /// Drive counts per count of change between two samples.
    pub kd: f64,
    /// Drive counts at full drive.
    pub saturation: f64,
    /// Weight of the previous sample, 0 to less than 1.
    pub filter: f64,
}

/// Optional columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Columns {
    /// `b{n}_cmd{k}_kpa`. On by default; an open-loop recording has no commands.
    pub command: bool,
    /// `b{n}_u{k}`: the drive in force from this row on.
    pub drive: bool,
    /// `b{n}_qu_rad`, `b{n}_qv_rad`.
    pub joints: bool,
    /// `supply_kpa`.
    pub supply: bool,
}

impl Default for Columns {
    /// The commands alone.
    fn default() -> Self {
        Self { command: true, drive: false, joints: false, supply: false }
    }
}

impl Default for ControlSettings {
    /// The nominal rig's controller: 1 kHz, the original's gains without derivative and filter.
    /// Virtual boards on a bus ([`RigOptions`](crate::rig::RigOptions)) run the firmware's law,
    /// which has both.
    fn default() -> Self {
        Self { rate_hz: 1000.0, kp: 10.0, kd: 0.0, saturation: 400.0, filter: 0.0 }
    }
}

impl From<&BoardConfig> for ControlSettings {
    /// The law of boards that are configured so.
    fn from(board: &BoardConfig) -> Self {
        Self {
            rate_hz: 1e6 / board.loop_period.get() as f64,
            kp: board.kp.into(),
            kd: board.kd.into(),
            saturation: board.saturation.into(),
            filter: f64::from(board.filter_previous) / 256.0,
        }
    }
}

impl Default for RecordingSettings {
    /// 220 s at 100 Hz of four channels under mixed excitation in closed loop on the board.
    fn default() -> Self {
        Self {
            plant: PlantParameters::default(),
            effects: Vec::new(),
            seed: 1,
            seconds: 220.0,
            rate_hz: 100.0,
            excitation: Excitation::Mixed,
            range_kpa: [50.0, 300.0],
            control_loop: Loop::Board { age: 0.5 },
            board: BoardKind::Firmware,
            control: ControlSettings::default(),
            columns: Columns::default(),
            exact: false,
        }
    }
}

impl RecordingSettings {
    /// Rows of the recording.
    #[must_use]
    pub fn rows(&self) -> u64 {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "validated: 0 to 1e8")]
        let rows = (self.seconds * self.rate_hz).round() as u64;
        rows
    }

    /// Checks every number that the plant does not check itself.
    ///
    /// # Errors
    /// Names the setting, its value and the range.
    pub fn validate(&self) -> Result<(), RecordError> {
        if matches!(self.control_loop, Loop::Open { .. }) && self.columns.command {
            return Err(RecordError::NoSetPoints);
        }
        let c = &self.control;
        let (age, amplitude) = match self.control_loop {
            Loop::Board { age } => (age, 0.0),
            Loop::Row => (0.0, 0.0),
            Loop::Open { amplitude } => (0.0, amplitude),
        };
        let [low, high] = self.range_kpa;
        let checks = [
            ("seconds", self.seconds, "s", 1e-3, 1e5, "0.001 to 100000"),
            ("rate_hz", self.rate_hz, "Hz", 1.0, 1000.0, "1 to 1000"),
            ("range_kpa low", low, "kPa", 0.0, 680.0, "0 to 680"),
            ("range_kpa high", high, "kPa", low, 680.0, "the low end to 680"),
            ("age", age, "loops", 0.0, 0.999, "0 to less than 1"),
            ("amplitude", amplitude, "1", 0.0, 1.0, "0 to 1"),
            ("control.rate_hz", c.rate_hz, "Hz", 50.0, 20_000.0, "50 to 20000"),
            ("control.kp", c.kp, "1", 0.0, 1e4, "0 to 10000"),
            ("control.kd", c.kd, "1", 0.0, 1e4, "0 to 10000"),
            ("control.saturation", c.saturation, "counts", 1.0, 1e6, "1 to 1000000"),
            ("control.filter", c.filter, "1", 0.0, 0.999, "0 to 0.999"),
        ];
        for (name, value, unit, min, max, expected) in checks {
            if !(min..=max).contains(&value) {
                return Err(RecordError::Setting { name, value, unit, expected });
            }
        }
        Ok(())
    }
}
