//! The board's real behaviour: the control crate, fed byte by byte.

use pneudrive_control::{AdcSample, Board, BoardConfig, DirPwm, Micros};
use pneudrive_protocol::{Address, Counts, Packet};

use crate::plant::CHANNELS_PER_BOARD;

use super::board_law::BoardLaw;
use super::error::RecordError;
use super::settings::ControlSettings;

/// Time zero on the board's clock, so that the first request's bytes can come before it.
const START_US: u64 = 1_000;
/// Time of a byte at 1 Mbaud, us.
const BYTE_US: u64 = 10;

/// One board of the control crate with the recording's gains, past its power-up vent.
#[derive(Debug, Clone)]
pub struct FirmwareBoard {
    board: Board,
}

impl FirmwareBoard {
    /// A board with these gains.
    ///
    /// # Errors
    /// Gains that the firmware's integers cannot hold, or that its own limits refuse.
    pub fn new(settings: ControlSettings) -> Result<Self, RecordError> {
        let config = BoardConfig {
            loop_period: Micros::new(whole("control period", "us", 1e6 / settings.rate_hz)?),
            kp: whole_u16("control.kp", settings.kp)?,
            kd: whole_u16("control.kd", settings.kd)?,
            saturation: whole_u16("control.saturation", settings.saturation)?,
            filter_previous: eighth_bits(settings.filter)?,
            power_up_vent: Micros::ZERO,
            // A recording's host never falls silent, however slow its rows.
            command_timeout: Micros::from_millis(10_000),
            ..BoardConfig::ORIGINAL
        };
        Ok(Self { board: Board::new(config, Address::of_board(0))? })
    }
}

impl BoardLaw for FirmwareBoard {
    fn step(&mut self, now_ns: u64, samples12: [u16; CHANNELS_PER_BOARD]) -> [f64; CHANNELS_PER_BOARD] {
        let now = Micros::new(START_US + now_ns / 1_000);
        let drives = self.board.control_step(now, samples12.map(AdcSample::from_reading));
        drives.map(|drive| f64::from(DirPwm::from(drive).coil()) / f64::from(DirPwm::DUTY_MAX))
    }

    fn exchange(&mut self, now_ns: u64, commands10: [u16; CHANNELS_PER_BOARD]) -> [u16; CHANNELS_PER_BOARD] {
        let request =
            Packet { address: self.board.address(), values: commands10.map(Counts::saturating) }.encode();
        let end = START_US + now_ns / 1_000;
        let mut answer = None;
        for (left, byte) in (0..request.len() as u64).rev().zip(request) {
            answer = self.board.receive_byte(Micros::new(end - left * BYTE_US), byte);
        }
        let packet = answer.and_then(|bytes| Packet::decode(&bytes).ok());
        // A whole request to its own address, on a quiet line, after a control step: the control
        // crate answers it.
        packet.map(|p| p.values.map(Counts::get)).expect("the board answers every exchange of a recording")
    }
}

fn whole(name: &'static str, unit: &'static str, value: f64) -> Result<u64, RecordError> {
    let rounded = value.round();
    if (value - rounded).abs() > 1e-9 || !(0.0..=65_535.0).contains(&rounded) {
        return Err(RecordError::Setting {
            name,
            value,
            unit,
            expected: "a whole number for the firmware's integers",
        });
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 65535")]
    let whole = rounded as u64;
    Ok(whole)
}

fn whole_u16(name: &'static str, value: f64) -> Result<u16, RecordError> {
    Ok(u16::try_from(whole(name, "counts", value)?).unwrap_or(u16::MAX))
}

/// A filter weight in 256ths, as the firmware holds it.
fn eighth_bits(filter: f64) -> Result<u8, RecordError> {
    let in_256ths = filter * 256.0;
    let expected = "a multiple of 1/256 below 1, as the firmware holds it";
    let refused = RecordError::Setting { name: "control.filter", value: filter, unit: "1", expected };
    let whole = whole("control.filter", "1/256", in_256ths).map_err(|_| refused)?;
    u8::try_from(whole).map_err(|_| RecordError::Setting {
        name: "control.filter",
        value: filter,
        unit: "1",
        expected,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn board(settings: ControlSettings) -> FirmwareBoard {
        FirmwareBoard::new(settings).unwrap()
    }

    /// Half of full drive at 20 counts of error, in 255ths of the PWM; the answer is the last
    /// loop's pressure.
    #[test]
    fn drives_and_answers_like_the_ideal_board() {
        let mut board = board(ControlSettings::default());
        board.step(0, [4 * 280; 4]);
        assert_eq!(board.exchange(500_000, [300, 320, 280, 102]), [280; 4]);
        let drives = board.step(1_000_000, [4 * 280; 4]);
        for (got, want) in drives.iter().zip([0.5, 1.0, 0.0, -1.0]) {
            assert!((got - want).abs() < 0.005, "{drives:?}");
        }
    }

    /// The rig file of boards on a bus is made from these settings: they must be those of the
    /// boards.
    #[test]
    fn a_configuration_comes_back_from_its_settings() {
        let wild = BoardConfig {
            loop_period: Micros::new(2_500),
            kp: 7,
            kd: 31,
            saturation: 333,
            filter_previous: 255,
            ..BoardConfig::ORIGINAL
        };
        for config in [BoardConfig::ORIGINAL, wild] {
            let power_up_vent = Micros::ZERO;
            let mut real = Board::new(BoardConfig { power_up_vent, ..config }, Address::of_board(0)).unwrap();
            let mut again = board(ControlSettings::from(&config));
            for step in 0..1_000_u64 {
                let now_ns = step * config.loop_period.get() * 1_000;
                if step % 50 == 7 {
                    let commands = [102 + (step % 700) as u16; 4];
                    let packet = Packet { address: real.address(), values: commands.map(Counts::saturating) };
                    for (byte, left) in packet.encode().into_iter().zip((0..10).rev()) {
                        real.receive_byte(Micros::new(START_US + now_ns / 1_000 - left * BYTE_US), byte);
                    }
                    again.exchange(now_ns, commands);
                }
                let samples =
                    [410 + step * 3 % 3_000, 3_600 - step * 3, 410 + step, 500].map(|code| code as u16);
                let drives = real.control_step(
                    Micros::new(START_US + now_ns / 1_000),
                    samples.map(AdcSample::from_reading),
                );
                let want =
                    drives.map(|drive| f64::from(DirPwm::from(drive).coil()) / f64::from(DirPwm::DUTY_MAX));
                assert_eq!(again.step(now_ns, samples), want, "step {step} of {config:?}");
            }
        }
    }

    #[test]
    fn gains_the_firmware_cannot_hold_are_refused() {
        let refusal = |settings| FirmwareBoard::new(settings).unwrap_err().to_string();
        assert!(refusal(ControlSettings { kp: 10.5, ..Default::default() }).contains("control.kp is 10.5"));
        assert!(refusal(ControlSettings { filter: 0.3, ..Default::default() }).contains("multiple of 1/256"));
        assert!(refusal(ControlSettings { rate_hz: 20_000.0, ..Default::default() }).contains("loop_period"));
        assert!(FirmwareBoard::new(ControlSettings { filter: 210.0 / 256.0, ..Default::default() }).is_ok());
    }
}
