//! Running a plant under an excitation, row by row.

use rand_chacha::ChaCha8Rng;

use crate::plant::noise::{Purpose, normal, stream};
use crate::plant::{CHANNELS_PER_BOARD, ChannelId, Plant, counts10_to_kpa, kpa_to_counts10};

use super::board_law::BoardLaw;
use super::drive_pattern::DrivePattern;
use super::error::RecordError;
use super::excitation::SetPoints;
use super::firmware_board::FirmwareBoard;
use super::ideal_board::{IdealBoard, to_10_bits};
use super::schedule::{LoopClock, instant_ns};
use super::settings::{BoardKind, Loop, RecordingSettings};

/// One exchange. The vectors count the channels (or boards) of the rig.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Time of the exchange, s.
    pub t_s: f64,
    /// Set points sent, kPa gauge, as the 10-bit counts that go over the bus; empty in open loop.
    pub command_kpa: Vec<f64>,
    /// Pressures answered, kPa gauge: measured at most one board loop before, without any effect of
    /// this row's command.
    pub pressure_kpa: Vec<f64>,
    /// Drives at the exchange, -1 to 1; held until the next row unless the loop is closed on the
    /// board.
    pub drive: Vec<f64>,
    /// Bending angles, rad, one pair a board, without measurement noise.
    pub angles_rad: Vec<[f64; 2]>,
    /// Supply at the valves, kPa gauge, through a sensor like the chambers'.
    pub supply_kpa: f64,
}

/// Runs the plant; an iterator over the rows.
pub struct Recorder {
    plant: Plant,
    control: Control,
    supply_noise: ChaCha8Rng,
    settings: RecordingSettings,
    row: u64,
}

/// Who sets the drives.
enum Control {
    /// Boards with their own loops.
    Boards { boards: Vec<Box<dyn BoardLaw + Send>>, clock: LoopClock, set_points: Vec<SetPoints> },
    /// A law that runs once a row.
    Rows { boards: Vec<IdealBoard>, set_points: Vec<SetPoints> },
    /// Nobody looks at the pressure, but for its range.
    Open { patterns: Vec<DrivePattern> },
}

impl Recorder {
    /// A recording with the boards of the settings.
    ///
    /// # Errors
    /// A setting, parameter or effect outside its range.
    pub fn new(settings: &RecordingSettings) -> Result<Self, RecordError> {
        let control = settings.control;
        match settings.board {
            BoardKind::Ideal => Self::with_law(settings, || Box::new(IdealBoard::new(control))),
            BoardKind::Firmware => {
                let board = FirmwareBoard::new(control);
                // Only a loop on the board needs one; the others may have gains it cannot hold.
                let needed = matches!(settings.control_loop, Loop::Board { .. });
                let board = if needed { Some(board?) } else { None };
                Self::with_law(settings, || match &board {
                    Some(board) => Box::new(board.clone()),
                    None => Box::new(IdealBoard::new(control)),
                })
            }
        }
    }

    /// A recording with other boards; `law` makes one. It is not used when the loop is closed once
    /// a row or open.
    ///
    /// # Errors
    /// As [`Recorder::new`].
    pub fn with_law(
        settings: &RecordingSettings,
        law: impl Fn() -> Box<dyn BoardLaw + Send>,
    ) -> Result<Self, RecordError> {
        settings.validate()?;
        let plant = Plant::new(settings.plant.clone(), &settings.effects, settings.seed)?;
        let places = 0..plant.channels();
        let range = settings.range_kpa;
        let set_points =
            places.clone().map(|place| SetPoints::new(settings.excitation, range, settings.seed, place));
        let control = match settings.control_loop {
            Loop::Board { age } => Control::Boards {
                boards: (0..plant.boards()).map(|_| law()).collect(),
                // The measurement is `age` loops old at a row when the loops run that long before
                // it.
                clock: LoopClock::new(settings.control.rate_hz, 1.0 - age),
                set_points: set_points.collect(),
            },
            Loop::Row => Control::Rows {
                boards: vec![IdealBoard::new(settings.control); plant.boards()],
                set_points: set_points.collect(),
            },
            Loop::Open { amplitude } => Control::Open {
                patterns: places.map(|p| DrivePattern::new(amplitude, range, settings.seed, p)).collect(),
            },
        };
        let supply_noise = stream(settings.seed, Purpose::SupplySensor, 0);
        let mut recorder = Self { plant, control, supply_noise, settings: settings.clone(), row: 0 };
        if let Control::Boards { boards, .. } = &mut recorder.control {
            // A board that has run before the first exchange has an answer to it.
            run_boards(boards, &mut recorder.plant, 0);
        }
        Ok(recorder)
    }

    /// The plant as it is now.
    #[must_use]
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    fn next_row(&mut self) -> Row {
        let time_ns = instant_ns(self.row, self.settings.rate_hz);
        let t_s = 1e-9 * time_ns as f64;
        let channels = self.plant.channels();
        let mut commands = Vec::new();
        let mut exact = None;
        let answers: Vec<u16> = match &mut self.control {
            Control::Boards { boards, clock, set_points } => {
                while let Some(loop_ns) = clock.next_until(time_ns) {
                    self.plant.advance_to(loop_ns);
                    exact = self.settings.exact.then(|| true_pressures(&self.plant));
                    run_boards(boards, &mut self.plant, loop_ns);
                }
                commands = counts_at(set_points, t_s);
                let sent = commands.chunks(CHANNELS_PER_BOARD);
                boards.iter_mut().zip(sent).flat_map(|(b, c)| b.exchange(time_ns, padded(c))).collect()
            }
            Control::Rows { boards, set_points } => {
                self.plant.advance_to(time_ns);
                commands = counts_at(set_points, t_s);
                let mut answers = Vec::new();
                for (index, board) in boards.iter_mut().enumerate() {
                    let samples = sampled(&mut self.plant, index);
                    board.exchange(time_ns, padded(&commands[index * CHANNELS_PER_BOARD..]));
                    apply_drives(&mut self.plant, index, board.step(time_ns, samples));
                    answers.extend(samples.map(to_10_bits));
                }
                answers
            }
            Control::Open { patterns } => {
                self.plant.advance_to(time_ns);
                let boards = 0..self.plant.boards();
                let answers: Vec<u16> =
                    boards.flat_map(|index| sampled(&mut self.plant, index).map(to_10_bits)).collect();
                for (place, pattern) in patterns.iter_mut().enumerate() {
                    let drive = pattern.at(t_s, counts10_to_kpa(f64::from(answers[place])));
                    apply_drive(&mut self.plant, place, drive);
                }
                answers
            }
        };
        self.plant.advance_to(time_ns);
        self.row += 1;
        let kpa = |counts: &u16| counts10_to_kpa(f64::from(*counts));
        Row {
            t_s,
            command_kpa: commands.iter().map(kpa).collect(),
            pressure_kpa: if self.settings.exact {
                exact.unwrap_or_else(|| true_pressures(&self.plant))
            } else {
                answers.iter().take(channels).map(kpa).collect()
            },
            drive: ids(&self.plant).map(|id| self.plant.truth(id).map_or(f64::NAN, |t| t.drive)).collect(),
            angles_rad: (0..self.plant.boards())
                .map(|board| self.plant.joint_angles(index_u8(board)).unwrap_or_default())
                .collect(),
            supply_kpa: self.measured_supply(),
        }
    }

    fn measured_supply(&mut self) -> f64 {
        let gauge = 1e-3 * (self.plant.supply_pressure_pa() - self.plant.ambient_pressure_pa());
        if self.settings.exact {
            return gauge;
        }
        let noisy = gauge + self.settings.plant.sensor.noise_kpa * normal(&mut self.supply_noise);
        counts10_to_kpa(kpa_to_counts10(noisy).round())
    }
}

impl Iterator for Recorder {
    type Item = Row;

    fn next(&mut self) -> Option<Row> {
        (self.row < self.settings.rows()).then(|| self.next_row())
    }
}

/// One loop of every board: sample, control, drive.
fn run_boards(boards: &mut [Box<dyn BoardLaw + Send>], plant: &mut Plant, now_ns: u64) {
    for (index, board) in boards.iter_mut().enumerate() {
        let samples = sampled(plant, index);
        apply_drives(plant, index, board.step(now_ns, samples));
    }
}

fn sampled(plant: &mut Plant, board: usize) -> [u16; CHANNELS_PER_BOARD] {
    plant.sample(index_u8(board)).expect("the recorder has the plant's boards")
}

/// Sets a board's drives; the last board's missing channels have no valve.
fn apply_drives(plant: &mut Plant, board: usize, drives: [f64; CHANNELS_PER_BOARD]) {
    let first = board * CHANNELS_PER_BOARD;
    for (place, drive) in (first..plant.channels()).zip(drives) {
        apply_drive(plant, place, drive);
    }
}

fn apply_drive(plant: &mut Plant, place: usize, drive: f64) {
    let channel = ChannelId::from_index(place).expect("the plant has at most 256 boards");
    plant.set_drive(channel, drive).expect("drives are clipped to -1 to 1");
}

/// Set points in counts, as they go over the bus.
fn counts_at(set_points: &mut [SetPoints], t_s: f64) -> Vec<u16> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "validated: 0 to 680 kPa")]
    set_points.iter_mut().map(|s| kpa_to_counts10(s.at(t_s)).round() as u16).collect()
}

/// A board's commands; channels it does not have are told 0 kPa.
fn padded(commands: &[u16]) -> [u16; CHANNELS_PER_BOARD] {
    let mut counts = [102; CHANNELS_PER_BOARD];
    for (to, from) in counts.iter_mut().zip(commands) {
        *to = *from;
    }
    counts
}

/// True pressures at the ports, kPa gauge.
fn true_pressures(plant: &Plant) -> Vec<f64> {
    let gauge = |pa: f64| 1e-3 * (pa - plant.ambient_pressure_pa());
    ids(plant).map(|id| plant.truth(id).map_or(f64::NAN, |t| gauge(t.port_pa))).collect()
}

fn ids(plant: &Plant) -> impl Iterator<Item = ChannelId> + use<> {
    (0..plant.channels()).filter_map(ChannelId::from_index)
}

/// Boards are few: the plant refuses more than 256.
fn index_u8(index: usize) -> u8 {
    u8::try_from(index).unwrap_or(u8::MAX)
}
