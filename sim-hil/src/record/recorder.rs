//! Running a plant under an excitation, row by row.

use rand_chacha::ChaCha8Rng;

use crate::plant::noise::{Purpose, normal, stream};
use crate::plant::{CHANNELS_PER_BOARD, ChannelId, Plant, counts10_to_kpa, kpa_to_counts10};

use super::controller::{BoardLaw, OriginalLaw};
use super::error::RecordError;
use super::excitation::SetPoints;
use super::schedule::{LoopClock, instant_ns};
use super::settings::{Loop, RecordingSettings};

/// One exchange. The vectors count the channels (or boards) of the rig.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Time of the exchange, s.
    pub t_s: f64,
    /// Set points sent, kPa gauge, as the 10-bit counts that go over the bus.
    pub command_kpa: Vec<f64>,
    /// Pressures answered, kPa gauge: measured at most one board loop before, without any effect of this row's command.
    pub pressure_kpa: Vec<f64>,
    /// Drives in force from this row on, -1 to 1.
    pub drive: Vec<f64>,
    /// Bending angles, rad, one pair a board, without measurement noise.
    pub angles_rad: Vec<[f64; 2]>,
    /// Supply at the valves, kPa gauge, through a sensor like the chambers'.
    pub supply_kpa: f64,
}

/// Runs the plant; an iterator over the rows.
pub struct Recorder {
    plant: Plant,
    boards: Vec<Box<dyn BoardLaw + Send>>,
    set_points: Vec<SetPoints>,
    clock: LoopClock,
    supply_noise: ChaCha8Rng,
    settings: RecordingSettings,
    row: u64,
}

impl Recorder {
    /// A recording with the original's control law on every board.
    ///
    /// # Errors
    /// A setting, parameter or effect outside its range.
    pub fn new(settings: &RecordingSettings) -> Result<Self, RecordError> {
        let control = settings.control;
        Self::with_law(settings, || Box::new(OriginalLaw::new(control)))
    }

    /// A recording with another control law; `law` makes one for each board.
    ///
    /// # Errors
    /// As [`Recorder::new`].
    pub fn with_law(
        settings: &RecordingSettings,
        law: impl Fn() -> Box<dyn BoardLaw + Send>,
    ) -> Result<Self, RecordError> {
        settings.validate()?;
        let plant = Plant::new(settings.plant.clone(), &settings.effects, settings.seed)?;
        let phase = match settings.control_loop {
            // The measurement is `age` loops old at a row when the loops run that long before it.
            Loop::Board { age } => 1.0 - age,
            Loop::Row => 0.0,
        };
        let set_points = (0..plant.channels())
            .map(|place| SetPoints::new(settings.excitation, settings.range_kpa, settings.seed, place))
            .collect();
        let mut recorder = Self {
            boards: (0..plant.boards()).map(|_| law()).collect(),
            plant,
            set_points,
            clock: LoopClock::new(settings.control.rate_hz, phase),
            supply_noise: stream(settings.seed, Purpose::SupplySensor, 0),
            settings: settings.clone(),
            row: 0,
        };
        if let Loop::Board { .. } = settings.control_loop {
            // A board that has run before the first exchange has an answer to it.
            recorder.board_loop();
        }
        Ok(recorder)
    }

    /// The plant as it is now.
    #[must_use]
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// One loop of every board: sample, control, drive.
    fn board_loop(&mut self) {
        for board in 0..self.boards.len() {
            let Ok(samples) = self.plant.sample(index_u8(board)) else { continue };
            self.boards[board].step(samples);
            self.apply_drives(board);
        }
    }

    fn apply_drives(&mut self, board: usize) {
        let drives = self.boards[board].drives();
        // The last board's missing channels have no valve.
        let first = board * CHANNELS_PER_BOARD;
        for (place, drive) in (first..self.plant.channels()).zip(drives) {
            let set = ChannelId::from_index(place).map(|channel| self.plant.set_drive(channel, drive));
            debug_assert!(matches!(set, Some(Ok(()))), "{set:?}");
        }
    }

    fn next_row(&mut self) -> Row {
        let time_ns = instant_ns(self.row, self.settings.rate_hz);
        let t_s = 1e-9 * time_ns as f64;
        let commands = self.commands(t_s);
        let (pressure_kpa, drive) = match self.settings.control_loop {
            Loop::Board { .. } => {
                while let Some(loop_ns) = self.clock.next_until(time_ns) {
                    self.plant.advance_to(loop_ns);
                    self.board_loop();
                }
                let measured = self.measured();
                self.plant.advance_to(time_ns);
                let drive = self.drives();
                self.send(&commands);
                (measured, drive)
            }
            Loop::Row => {
                self.plant.advance_to(time_ns);
                self.send(&commands);
                self.board_loop();
                (self.measured(), self.drives())
            }
        };
        self.row += 1;
        Row {
            t_s,
            command_kpa: commands.iter().map(|&c| counts10_to_kpa(f64::from(c))).collect(),
            pressure_kpa,
            drive,
            angles_rad: (0..self.boards.len())
                .map(|b| self.plant.joint_angles(index_u8(b)).unwrap_or_default())
                .collect(),
            supply_kpa: self.measured_supply(),
        }
    }

    /// Set points in counts, as they go over the bus.
    fn commands(&mut self, t_s: f64) -> Vec<u16> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "validated: 0 to 680 kPa"
        )]
        self.set_points.iter_mut().map(|s| kpa_to_counts10(s.at(t_s)).round() as u16).collect()
    }

    fn send(&mut self, commands: &[u16]) {
        for (board, commands) in self.boards.iter_mut().zip(commands.chunks(CHANNELS_PER_BOARD)) {
            let mut counts = [102; CHANNELS_PER_BOARD];
            counts[..commands.len()].copy_from_slice(commands);
            board.set_commands(counts);
        }
    }

    /// Pressures the boards answer, or the true ones of the last board loop.
    fn measured(&self) -> Vec<f64> {
        if self.settings.exact {
            let ambient = self.plant.ambient_pressure_pa();
            let truth = |id| self.plant.truth(id).map_or(f64::NAN, |t| 1e-3 * (t.port_pa - ambient));
            return self.channel_ids().map(truth).collect();
        }
        let answers = self.boards.iter().flat_map(|b| b.pressures());
        answers.take(self.plant.channels()).map(|counts| counts10_to_kpa(f64::from(counts))).collect()
    }

    fn drives(&self) -> Vec<f64> {
        self.boards.iter().flat_map(|b| b.drives()).take(self.plant.channels()).collect()
    }

    fn measured_supply(&mut self) -> f64 {
        let gauge = 1e-3 * (self.plant.supply_pressure_pa() - self.plant.ambient_pressure_pa());
        if self.settings.exact {
            return gauge;
        }
        let noisy = gauge + self.settings.plant.sensor.noise_kpa * normal(&mut self.supply_noise);
        counts10_to_kpa(kpa_to_counts10(noisy).round())
    }

    fn channel_ids(&self) -> impl Iterator<Item = ChannelId> + use<> {
        (0..self.plant.channels()).filter_map(ChannelId::from_index)
    }
}

impl Iterator for Recorder {
    type Item = Row;

    fn next(&mut self) -> Option<Row> {
        (self.row < self.settings.rows()).then(|| self.next_row())
    }
}

/// Boards and channels are few: the plant refuses more than 256 boards.
fn index_u8(index: usize) -> u8 {
    u8::try_from(index).unwrap_or(u8::MAX)
}
