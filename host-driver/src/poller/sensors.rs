//! A board is asked for the sensors on its I2C connector, between two polls.

use super::page_share::PageSchedule;
use super::{ElectronicsReading, Event, Motion, PageShare, Polling, SupplyPressure};
use crate::bus::{BoardFormat, ExchangeError, PageError};
use crate::line::{Line, LineError};
use pneudrive_protocol::pages::{SensorPart, SensorState, SensorStatus, Temperature, Voltage};

/// What is asked for next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Turn {
    Status,
    Supply,
    Motion,
    Electronics,
}

/// Decides for one board: what it has is asked for in turn, and now and then what it has, and how
/// warm it is.
#[derive(Debug, Clone)]
pub(super) struct SensorSchedule {
    pages: PageSchedule,
    /// What it said last, and when, ns.
    status: Option<(SensorStatus, u64)>,
    /// When it is to be asked for temperature and voltage, ns.
    electronics_from_ns: u64,
    /// Whether the last question was for one of these, and not for a reading.
    seldom_was_last: bool,
    /// Which of the two was asked for last.
    status_was_last: bool,
    motion_was_last: bool,
}

impl SensorSchedule {
    /// Parts may be plugged in, or out: asked so often, ns.
    const STATUS_EVERY_NS: u64 = 1_000_000_000;
    /// A mean takes a board so long, ns.
    const ELECTRONICS_EVERY_NS: u64 = 1_000_000_000;
    /// Firmware that does not know the question may be brought a new one, ns.
    const UNKNOWN_AGAIN_NS: u64 = 60_000_000_000;

    pub(super) fn new(share: Option<PageShare>) -> Self {
        Self {
            pages: PageSchedule::new(share),
            status: None,
            electronics_from_ns: 0,
            seldom_was_last: false,
            status_was_last: false,
            motion_was_last: false,
        }
    }

    /// What the board, which has answered a poll, is to be asked for now.
    fn due(&mut self, now_ns: u64) -> Option<Turn> {
        self.pages.due(now_ns).then(|| {
            let turn = self.turn(now_ns);
            self.seldom_was_last = matches!(turn, Turn::Status | Turn::Electronics);
            if self.seldom_was_last {
                self.status_was_last = turn == Turn::Status;
            } else {
                self.motion_was_last = turn == Turn::Motion;
            }
            turn
        })
    }

    fn turn(&self, now_ns: u64) -> Turn {
        let Some((status, at_ns)) = self.status else { return Turn::Status };
        let (supply, imu) = (status.supply != SensorPart::None, status.imu != SensorPart::None);
        // However seldom a board is asked, every second question is for a reading.
        if !self.seldom_was_last || !(supply || imu) {
            let status_is_due = now_ns.saturating_sub(at_ns) >= Self::STATUS_EVERY_NS;
            match (status_is_due, now_ns >= self.electronics_from_ns) {
                (true, true) if self.status_was_last => return Turn::Electronics,
                (true, _) => return Turn::Status,
                (false, true) => return Turn::Electronics,
                (false, false) => {}
            }
        }
        match (supply, imu) {
            (false, false) => Turn::Status,
            (true, false) => Turn::Supply,
            (false, true) => Turn::Motion,
            (true, true) if self.motion_was_last => Turn::Supply,
            (true, true) => Turn::Motion,
        }
    }

    /// What it has. Says whether that is news.
    fn has(&mut self, status: SensorStatus, now_ns: u64) -> bool {
        let parts = |s: &SensorStatus| (s.supply, s.supply_state, s.imu, s.imu_state);
        let before = self.status.replace((status, now_ns));
        self.rest(now_ns);
        before.is_none_or(|(before, _)| parts(&before) != parts(&status))
    }

    /// It was asked for temperature and voltage, and is again after `pause_ns`.
    fn electronics_asked(&mut self, now_ns: u64, pause_ns: u64) {
        self.electronics_from_ns = now_ns + pause_ns;
        self.rest(now_ns);
    }

    /// A board that has no parts, and has said so, has a pause.
    fn rest(&mut self, now_ns: u64) {
        let has_nothing =
            |status: SensorStatus| (status.supply, status.imu) == (SensorPart::None, SensorPart::None);
        let is_known = self.status.is_some_and(|(status, at_ns)| {
            has_nothing(status) && now_ns.saturating_sub(at_ns) < Self::STATUS_EVERY_NS
        });
        if is_known && now_ns < self.electronics_from_ns {
            self.pages.pause(now_ns);
        }
    }
}

impl<L: Line> Polling<L> {
    /// Asks the board at `index`, which has just answered, for one of its sensors if that is due.
    pub(super) fn ask_for_sensors(&mut self, index: usize) -> Result<(), LineError> {
        let board = self.rows[index].board;
        let now_ns = self.bus.line().now_ns();
        if self.bus.format(board) != BoardFormat::Checked {
            return Ok(());
        }
        let Some(turn) = self.sensors[index].due(now_ns) else { return Ok(()) };
        let asked = match turn {
            Turn::Status => self.ask_what_there_is(index),
            Turn::Supply => self.ask_for_supply(index),
            Turn::Motion => self.ask_for_motion(index),
            Turn::Electronics => self.ask_for_electronics(index),
        };
        match asked {
            Ok(()) => self.sensors[index].pages.answered(),
            Err(PageError::Exchange(ExchangeError::Line(error))) => return Err(error),
            Err(error) => {
                if self.sensors[index].pages.failed(self.bus.line().now_ns()) {
                    self.tell(&Event::NoSensors { board, error: &error });
                }
            }
        }
        Ok(())
    }

    fn ask_what_there_is(&mut self, index: usize) -> Result<(), PageError> {
        let board = self.rows[index].board;
        let status = self.bus.sensors(board)?;
        let sensors = &mut self.rows[index].sensors;
        sensors.supply = sensors.supply.filter(|_| status.supply_state == SensorState::Live);
        sensors.motion = sensors.motion.filter(|_| status.imu_state == SensorState::Live);
        if self.sensors[index].has(status, self.bus.line().now_ns()) {
            self.tell(&Event::Sensors { board, status: &status });
        }
        Ok(())
    }

    fn ask_for_supply(&mut self, index: usize) -> Result<(), PageError> {
        let (reading, asked_ns) = self.bus.supply(self.rows[index].board)?;
        let sensors = &mut self.rows[index].sensors;
        let measured_ns = asked_ns.saturating_sub(u64::from(reading.age_ms) * 1_000_000);
        sensors.supply = reading.live_kpa().map(|kpa| SupplyPressure { kpa, measured_ns });
        sensors.supply_is_new = sensors.supply.is_some();
        Ok(())
    }

    /// Two pages: the second is made up for by one that is left out.
    fn ask_for_motion(&mut self, index: usize) -> Result<(), PageError> {
        let board = self.rows[index].board;
        let (acceleration, asked_ns) = self.bus.acceleration(board)?;
        self.sensors[index].pages.asked_for_more();
        let (rate, _) = self.bus.angular_rate(board)?;
        let live = acceleration.state() == SensorState::Live && rate.state() == SensorState::Live;
        let sensors = &mut self.rows[index].sensors;
        sensors.motion = acceleration.m_per_s2().zip(rate.rad_per_s()).filter(|_| live).map(
            |(acceleration_m_s2, angular_rate_rad_s)| Motion {
                acceleration_m_s2,
                angular_rate_rad_s,
                asked_ns,
            },
        );
        sensors.motion_is_new = sensors.motion.is_some();
        Ok(())
    }

    fn ask_for_electronics(&mut self, index: usize) -> Result<(), PageError> {
        let asked = self.bus.electronics(self.rows[index].board);
        let now_ns = self.bus.line().now_ns();
        let sensors = &mut self.rows[index].sensors;
        let (pause_ns, reading) = match asked {
            Ok((electronics, asked_ns)) => {
                let chip_c = electronics.chip_temperature.map(Temperature::celsius);
                let rail_v = electronics.rail_voltage.map(Voltage::volts);
                let reading = ElectronicsReading { chip_c, rail_v, asked_ns };
                (SensorSchedule::ELECTRONICS_EVERY_NS, Some(reading))
            }
            // Firmware of before this page tells the others.
            Err(PageError::NoSuchEntry { .. }) => (SensorSchedule::UNKNOWN_AGAIN_NS, None),
            Err(error) => return Err(error),
        };
        (sensors.electronics, sensors.electronics_is_new) = (reading, reading.is_some());
        self.sensors[index].electronics_asked(now_ns, pause_ns);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn status(supply: SensorPart, imu: SensorPart) -> SensorStatus {
        SensorStatus { supply, imu, ..SensorStatus::NONE }
    }

    /// What is asked for after each of these polls, one a ms.
    fn turns(share: f64, polls: u64, status: SensorStatus) -> Vec<(u64, Turn)> {
        let mut schedule = SensorSchedule::new(Some(PageShare::new(share).unwrap()));
        let mut turns = Vec::new();
        for poll in 0..polls {
            let Some(turn) = schedule.due(poll * MS) else { continue };
            match turn {
                Turn::Status => drop(schedule.has(status, poll * MS)),
                Turn::Motion => schedule.pages.asked_for_more(),
                Turn::Supply => {}
                Turn::Electronics => {
                    schedule.electronics_asked(poll * MS, SensorSchedule::ELECTRONICS_EVERY_NS)
                }
            }
            schedule.pages.answered();
            turns.push((poll, turn));
        }
        turns
    }

    fn count(turns: &[(u64, Turn)], what: Turn) -> usize {
        turns.iter().filter(|(_, turn)| *turn == what).count()
    }

    #[test]
    fn both_are_read_in_turn_and_an_imu_takes_two_pages() {
        let turns = turns(0.1, 2_000, status(SensorPart::Ads1115, SensorPart::Bmi323));
        let [status, electronics, supply, motion] =
            [Turn::Status, Turn::Electronics, Turn::Supply, Turn::Motion].map(|t| count(&turns, t));
        assert_eq!((status, electronics), (2, 2));
        // The second page of the last one is made up for later.
        let pages = status + electronics + supply + 2 * motion;
        assert!((200..=201).contains(&pages), "{supply} {motion}");
        assert!(supply.abs_diff(motion) <= 1, "{supply} {motion}");
    }

    #[test]
    fn only_what_there_is_is_asked_for() {
        let supply = turns(0.5, 2_000, status(SensorPart::Ads1115, SensorPart::None));
        assert_eq!((count(&supply, Turn::Supply), count(&supply, Turn::Motion)), (996, 0));
        let imu = turns(0.5, 2_000, status(SensorPart::None, SensorPart::Bmi323));
        assert_eq!((count(&imu, Turn::Supply), count(&imu, Turn::Motion)), (0, 498));
        let none = turns(0.5, 4_000, SensorStatus::NONE);
        let seconds = [0, 1_002, 2_004, 3_006];
        let expected = seconds.map(|poll| [(poll, Turn::Status), (poll + 2, Turn::Electronics)]).concat();
        assert_eq!(none, expected, "once a second");
    }

    /// A question in 700 ms: never more than every second one is for the status.
    #[test]
    fn who_is_asked_seldom_is_asked_for_readings_too() {
        let turns = turns(1.0 / 700.0, 14_000, status(SensorPart::Ads1115, SensorPart::Bmi323));
        assert!(count(&turns, Turn::Supply) >= 3 && count(&turns, Turn::Motion) >= 3, "{turns:?}");
        let seldom = count(&turns, Turn::Status) + count(&turns, Turn::Electronics);
        assert!(count(&turns, Turn::Electronics) >= 3 && seldom <= turns.len() / 2 + 1, "{turns:?}");
    }

    #[test]
    fn what_has_changed_is_news_and_counts_are_not() {
        let mut schedule = SensorSchedule::new(None);
        let live =
            SensorStatus { supply_state: SensorState::Live, ..status(SensorPart::Ads1115, SensorPart::None) };
        assert!(schedule.has(live, 0));
        assert!(!schedule.has(SensorStatus { errors: 7, recoveries: 1, ..live }, 1));
        assert!(schedule.has(SensorStatus { supply_state: SensorState::Stale, ..live }, 2));
        assert!(schedule.has(SensorStatus::NONE, 3));
    }
}
