use crate::{BoardState, BoardStatus, ChannelStatus, Micros};

impl BoardStatus {
    /// Whether the status LED is lit at `now`: on while all is well, a slow blink (1 Hz) while the
    /// board vents or holds for want of a host, a fast blink (5 Hz) while a sensor is faulty.
    pub fn led_is_on(&self, now: Micros) -> bool {
        const SLOW_HALF_PERIOD_US: u64 = 500_000;
        const FAST_HALF_PERIOD_US: u64 = 100_000;
        let blink = |half_period_us: u64| (now.get() / half_period_us).is_multiple_of(2);
        if self.channels.iter().any(|channel| matches!(channel, ChannelStatus::SensorFault(_))) {
            blink(FAST_HALF_PERIOD_US)
        } else if self.state == BoardState::Running {
            true
        } else {
            blink(SLOW_HALF_PERIOD_US)
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{AdcSample, Board, BoardConfig, Micros};
    use pneudrive_protocol::{Address, Counts};

    /// Edges of the LED in the second from `from_ms` on.
    fn edges(board: &Board, from_ms: u64) -> usize {
        let lit = |ms| board.status().led_is_on(Micros::from_millis(ms));
        (from_ms..from_ms + 1_000).filter(|&ms| lit(ms) != lit(ms + 1)).count()
    }

    #[test]
    fn the_led_tells_three_conditions_apart() {
        let config = BoardConfig { power_up_vent: Micros::ZERO, ..BoardConfig::default() };
        let mut board = Board::new(config, Address::of_board(0)).unwrap();
        assert_eq!(edges(&board, 0), 2, "power-up vent");
        let mut samples = [AdcSample::from(Counts::ATMOSPHERE); 4];
        board.control_step(Micros::ZERO, samples);
        assert_eq!(edges(&board, 0), 0, "running");
        samples[2] = AdcSample::from(Counts::MIN);
        for step in 1..=10 {
            board.control_step(Micros::from_millis(step), samples);
        }
        assert_eq!(edges(&board, 0), 10, "sensor fault");
    }
}
