//! The control law a recording runs.

use crate::plant::CHANNELS_PER_BOARD;

use super::settings::ControlSettings;

/// A board as far as a recording needs it: samples in, drives out, once a loop.
pub trait BoardLaw {
    /// Takes new set points, 10-bit counts.
    fn set_commands(&mut self, counts10: [u16; CHANNELS_PER_BOARD]);
    /// One loop: takes the samples (12-bit counts) and computes the drives.
    fn step(&mut self, samples12: [u16; CHANNELS_PER_BOARD]);
    /// Pressures the board would answer now, 10-bit counts.
    fn pressures(&self) -> [u16; CHANNELS_PER_BOARD];
    /// Drives of the last loop, -1 (vent) to 1 (fill).
    fn drives(&self) -> [f64; CHANNELS_PER_BOARD];
}

/// The original's law in the original's units, without its integer rounding.
///
/// `drive = kp (command - pressure) - kd (pressure - previous)`, clipped, over `saturation`; the pressure is the 12-bit sample
/// rounded to 10 bits and low-passed. Commands start at 102 counts (0 kPa).
#[derive(Debug, Clone)]
pub struct OriginalLaw {
    settings: ControlSettings,
    commands: [u16; CHANNELS_PER_BOARD],
    filtered: Option<[f64; CHANNELS_PER_BOARD]>,
    drives: [f64; CHANNELS_PER_BOARD],
}

impl OriginalLaw {
    /// A board at power-up.
    #[must_use]
    pub fn new(settings: ControlSettings) -> Self {
        Self {
            settings,
            commands: [102; CHANNELS_PER_BOARD],
            filtered: None,
            drives: [0.0; CHANNELS_PER_BOARD],
        }
    }
}

impl BoardLaw for OriginalLaw {
    fn set_commands(&mut self, counts10: [u16; CHANNELS_PER_BOARD]) {
        self.commands = counts10;
    }

    fn step(&mut self, samples12: [u16; CHANNELS_PER_BOARD]) {
        let s = &self.settings;
        let samples = samples12.map(to_10_bits);
        // The first sample starts the filter where it is, not at zero.
        let previous = self.filtered.unwrap_or(samples);
        let mut filtered = samples;
        for k in 0..CHANNELS_PER_BOARD {
            filtered[k] = s.filter * previous[k] + (1.0 - s.filter) * samples[k];
            let error = f64::from(self.commands[k]) - filtered[k];
            let drive = s.kp * error - s.kd * (filtered[k] - previous[k]);
            self.drives[k] = (drive / s.saturation).clamp(-1.0, 1.0);
        }
        self.filtered = Some(filtered);
    }

    fn pressures(&self) -> [u16; CHANNELS_PER_BOARD] {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "samples are 0 to 1023")]
        self.filtered.map_or([102; CHANNELS_PER_BOARD], |f| f.map(|counts| counts.round() as u16))
    }

    fn drives(&self) -> [f64; CHANNELS_PER_BOARD] {
        self.drives
    }
}

/// A 12-bit sample rounded to the bus's 10 bits.
fn to_10_bits(sample12: u16) -> f64 {
    f64::from(((sample12 + 2) / 4).min(1023))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn proportional_part_is_full_at_forty_counts() {
        let mut law = OriginalLaw::new(ControlSettings::default());
        law.set_commands([300, 300, 300, 300]);
        law.step([4 * 260, 4 * 280, 4 * 300, 4 * 400]);
        assert_eq!(law.drives(), [1.0, 0.5, 0.0, -1.0]);
        assert_eq!(law.pressures(), [260, 280, 300, 400]);
    }

    #[test]
    fn filter_and_derivative_act_on_the_pressure() {
        let settings = ControlSettings { filter: 0.5, kd: 20.0, kp: 0.0, ..ControlSettings::default() };
        let mut law = OriginalLaw::new(settings);
        law.step([400; 4]);
        assert_eq!(law.drives(), [0.0; 4]);
        law.step([440; 4]); // 10 counts up, half of it passes: -20 * 5 / 400
        assert_eq!(law.drives(), [-0.25; 4]);
        assert_eq!(law.pressures(), [105; 4]);
    }
}
