//! The quantities that the models and the simulated board are made of.

use super::{Rig, RigError};
use pneudrive_plant::board::{Arithmetic, Board};
use pneudrive_plant::model::{Constants, FlowForm, FlowFunction, Gas, ValveDrive};

impl Rig {
    /// The air, at the temperature and the pressure of the room.
    #[must_use]
    pub fn gas(&self) -> Gas {
        let ambient = self.ambient_or_standard();
        let ambient_pa = ambient.pressure_kpa_abs * 1e3;
        Gas { temperature_k: ambient.temperature_k, ambient_pa, ..Gas::default() }
    }

    /// What models take of it: of its valves, or of usual ones where they are not described.
    #[must_use]
    pub fn constants(&self, drive: ValveDrive, form: FlowForm) -> Constants {
        let valve = self.valve.clone().unwrap_or_default();
        Constants {
            gas: self.gas(),
            flow: FlowFunction::new(valve.critical_ratio, form),
            discharge_coefficient: valve.discharge_coefficient,
            drive,
        }
    }

    /// The board in front of a valve.
    ///
    /// # Errors
    /// [`RigError::MissingTable`] when the controller or the sensor is not described.
    pub fn board(&self) -> Result<Board, RigError> {
        let missing = |table| RigError::MissingTable { table, purpose: "the simulation of the board's loop" };
        let controller = self.controller.ok_or_else(|| missing("controller"))?;
        let sensor = self.sensor.ok_or_else(|| missing("sensor"))?;
        Ok(Board { controller, arithmetic: Arithmetic::default(), sensor, ambient_pa: self.gas().ambient_pa })
    }
}
