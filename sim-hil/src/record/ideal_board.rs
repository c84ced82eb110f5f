//! The original's control law without integers.

use crate::plant::CHANNELS_PER_BOARD;

use super::board_law::BoardLaw;
use super::settings::ControlSettings;

/// The original's law in the original's units.
///
/// `drive = kp (command - pressure) - kd (pressure - previous)`, over `saturation`, clipped at 1;
/// the pressure is the 12-bit sample rounded to 10 bits and low-passed. Commands start at 102
/// counts (0 kPa).
#[derive(Debug, Clone)]
pub struct IdealBoard {
    settings: ControlSettings,
    commands: [u16; CHANNELS_PER_BOARD],
    filtered: Option<[f64; CHANNELS_PER_BOARD]>,
}

impl IdealBoard {
    /// A board at power-up.
    #[must_use]
    pub fn new(settings: ControlSettings) -> Self {
        Self { settings, commands: [102; CHANNELS_PER_BOARD], filtered: None }
    }
}

impl BoardLaw for IdealBoard {
    fn step(&mut self, _now_ns: u64, samples12: [u16; CHANNELS_PER_BOARD]) -> [f64; CHANNELS_PER_BOARD] {
        let s = &self.settings;
        let samples = samples12.map(|sample| f64::from(to_10_bits(sample)));
        // The first sample starts the filter where it is, not at zero.
        let previous = self.filtered.unwrap_or(samples);
        let mut filtered = samples;
        let mut drives = [0.0; CHANNELS_PER_BOARD];
        for k in 0..CHANNELS_PER_BOARD {
            filtered[k] = s.filter * previous[k] + (1.0 - s.filter) * samples[k];
            let error = f64::from(self.commands[k]) - filtered[k];
            let drive = s.kp * error - s.kd * (filtered[k] - previous[k]);
            drives[k] = (drive / s.saturation).clamp(-1.0, 1.0);
        }
        self.filtered = Some(filtered);
        drives
    }

    fn exchange(&mut self, _now_ns: u64, commands10: [u16; CHANNELS_PER_BOARD]) -> [u16; CHANNELS_PER_BOARD] {
        self.commands = commands10;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "samples are 0 to 1023")]
        self.filtered.map_or([102; CHANNELS_PER_BOARD], |f| f.map(|counts| counts.round() as u16))
    }
}

/// A 12-bit sample rounded to the bus's 10 bits, half counts to the even one: rounding them up
/// would add an eighth of a count (0.1 kPa) in the mean.
pub fn to_10_bits(sample12: u16) -> u16 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 1023")]
    let counts = (f64::from(sample12) / 4.0).round_ties_even().min(1023.0) as u16;
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn proportional_part_is_full_at_forty_counts() {
        let mut board = IdealBoard::new(ControlSettings::default());
        board.exchange(0, [300; 4]);
        assert_eq!(board.step(0, [4 * 260, 4 * 280, 4 * 300, 4 * 400]), [1.0, 0.5, 0.0, -1.0]);
        assert_eq!(board.exchange(0, [300; 4]), [260, 280, 300, 400]);
    }

    #[test]
    fn filter_and_derivative_act_on_the_pressure() {
        let settings = ControlSettings { filter: 0.5, kd: 20.0, kp: 0.0, ..ControlSettings::default() };
        let mut board = IdealBoard::new(settings);
        assert_eq!(board.step(0, [400; 4]), [0.0; 4]);
        // 10 counts up, half of it passes: -20 * 5 / 400
        assert_eq!(board.step(0, [440; 4]), [-0.25; 4]);
        assert_eq!(board.exchange(0, [102; 4]), [105; 4]);
    }

    #[test]
    fn samples_round_to_the_nearest_count() {
        assert_eq!([409, 410, 411, 413, 414, 4095].map(to_10_bits), [102, 102, 103, 103, 104, 1023]);
    }
}
