//! Readings of the sensors on the boards' I2C connectors: from the bus thread to topics of their
//! own.

use crate::publish::Clocks;
use pneudrive_host::poller::{Motion, Observer, Row, SupplyPressure};
use pneudrive_host::rig::Rig;
use pneudrive_record::RecorderOptions;
use pneudrive_record::messages::{FluidPressure, Imu};
use ros2_client::Publisher;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// What a board told in one cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Its place in the poller's order.
    index: usize,
    supply: Option<SupplyPressure>,
    motion: Option<Motion>,
}

/// Sits on the bus thread, which does not wait: what does not fit is dropped.
pub struct SensorTap {
    readings: SyncSender<Reading>,
}

impl SensorTap {
    /// Readings that may wait for the publisher.
    const QUEUE: usize = 256;

    /// The tap, and its other end.
    pub fn new() -> (Self, Receiver<Reading>) {
        let (readings, receiver) = sync_channel(Self::QUEUE);
        (Self { readings }, receiver)
    }
}

impl Observer for SensorTap {
    fn row(&mut self, row: &Row<'_>) {
        for (index, board) in row.boards.iter().enumerate() {
            let (supply, motion) = (board.sensors.new_supply(), board.sensors.new_motion());
            if supply.is_some() || motion.is_some() {
                // A full queue means that the publisher is stuck; the next reading is as good.
                let _ = self.readings.try_send(Reading { index, supply, motion });
            }
        }
    }
}

/// The topics of one joint. Those of parts that its board does not have stay silent.
pub struct SensorTopics {
    supply: Publisher<FluidPressure>,
    supply_message: FluidPressure,
    imu: Publisher<Imu>,
    imu_message: Imu,
}

impl SensorTopics {
    /// Of this joint, on these topics.
    pub fn new(joint: u16, supply: Publisher<FluidPressure>, imu: Publisher<Imu>) -> Self {
        let (supply_message, imu_message) = (FluidPressure::of_joint(joint), Imu::of_joint(joint));
        Self { supply, supply_message, imu, imu_message }
    }
}

/// Pressure of the atmosphere, kPa absolute: the rig file's, or the standard one.
pub fn ambient_kpa(rig: Option<&Rig>) -> f64 {
    rig.and_then(Rig::ambient_kpa).unwrap_or(RecorderOptions::STANDARD_ATMOSPHERE_KPA)
}

/// Publishes until the bus thread has ended.
pub fn run(mut topics: Vec<SensorTopics>, readings: &Receiver<Reading>, ambient_kpa: f64) {
    let mut clocks = Clocks::new();
    for reading in readings {
        let Some(topics) = topics.get_mut(reading.index) else { continue };
        // What DDS does not take is lost; the next reading is as good.
        if let Some(supply) = reading.supply {
            topics.supply_message.fill(clocks.stamp(supply.measured_ns), supply.kpa, ambient_kpa);
            let _ = topics.supply.publish(topics.supply_message.clone());
        }
        if let Some(motion) = reading.motion {
            let (acceleration, rate) = (motion.acceleration_m_s2, motion.angular_rate_rad_s);
            topics.imu_message.fill(clocks.stamp(motion.asked_ns), acceleration, rate);
            let _ = topics.imu.publish(topics.imu_message.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneudrive_host::poller::{BoardRow, BoardSensors, BoardState, Outcome, VENTED};

    #[test]
    fn only_what_is_new_is_passed_on_and_the_bus_thread_does_not_wait() {
        let (mut tap, readings) = SensorTap::new();
        let supply = Some(SupplyPressure { kpa: 550.0, measured_ns: 7 });
        let row = |supply_is_new| BoardRow {
            board: 0,
            command: VENTED,
            wanted: VENTED,
            outcome: Outcome::Fresh,
            reading: None,
            drives: None,
            sensors: BoardSensors { supply, supply_is_new, ..BoardSensors::default() },
            state: BoardState::Present,
        };
        let boards = [row(false), row(true)];
        for cycle in 0..SensorTap::QUEUE as u64 + 10 {
            tap.row(&Row { cycle, at_ns: cycle, since_start_ns: cycle, boards: &boards });
        }
        drop(tap);
        let passed_on: Vec<_> = readings.iter().collect();
        assert_eq!(passed_on.len(), SensorTap::QUEUE);
        assert_eq!(passed_on[0], Reading { index: 1, supply, motion: None });
    }

    #[test]
    fn the_atmosphere_is_the_rig_files_or_the_standard_one() {
        let rig = Rig::parse("rig.toml", "[ambient]\npressure_kpa_abs = 95.0\n").unwrap();
        assert_eq!((ambient_kpa(Some(&rig)), ambient_kpa(None)), (95.0, 101.325));
    }
}
