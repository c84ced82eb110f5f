use crate::bus::{Air, JointNow};
use crate::plant::{ChannelId, Plant};

/// The truth plant as the boards' air.
#[derive(Debug)]
pub struct PlantAir {
    plant: Plant,
    step_ns: u64,
}

impl PlantAir {
    /// Puts `plant` (of this integration step, ns) behind the boards: board n has its channels 4n
    /// to 4n + 3.
    pub fn new(plant: Plant, step_ns: u64) -> Self {
        Self { plant, step_ns }
    }

    /// Sensors of a board that the plant has no channels for: 0.5 V of 5 V, atmosphere.
    const ATMOSPHERE: [u16; 4] = [410; 4];
}

impl Air for PlantAir {
    fn sample(&mut self, board: u8, now_ns: u64) -> [u16; 4] {
        self.plant.advance_to(now_ns);
        self.plant.sample(board).unwrap_or(Self::ATMOSPHERE)
    }

    fn drive(&mut self, board: u8, now_ns: u64, drives: [f64; 4]) {
        self.plant.advance_to(now_ns);
        for (channel, drive) in (0..).zip(drives) {
            // A board with fewer channels than four has nothing on the other outputs.
            let _ = self.plant.set_drive(ChannelId { board, channel }, drive);
        }
    }

    fn supply_pa(&mut self, now_ns: u64) -> Option<f64> {
        self.plant.advance_to(now_ns);
        Some(self.plant.supply_pressure_pa() - self.plant.ambient_pressure_pa())
    }

    fn joint(&mut self, board: u8, now_ns: u64) -> JointNow {
        self.plant.advance_to(now_ns);
        JointNow {
            angles_rad: self.plant.joint_angles(board).unwrap_or_default(),
            rates_rad_s: self.plant.joint_rates(board).unwrap_or_default(),
        }
    }

    fn work_ahead(&mut self, until_ns: u64) -> bool {
        let next_ns = self.plant.time_ns() + self.step_ns;
        if next_ns > until_ns {
            return false;
        }
        self.plant.advance_to(next_ns);
        next_ns + self.step_ns <= until_ns
    }
}
