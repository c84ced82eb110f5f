//! What a user chooses about a simulation.

use serde::{Deserialize, Serialize};

use crate::data::{Channel, Drive, InputError, Needs, Recording};
use crate::model::ValveDrive;
use crate::rig::{Rig, RigError};
use crate::rollout::ModelKind;

/// Whether the board's pressure loop is part of the simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ControllerUse {
    /// Where the drive is not recorded.
    #[default]
    Auto,
    /// Always: from commands alone, even where the drive is recorded.
    On,
    /// Never: the drive must be recorded.
    Off,
}

/// Which valve the nonlinear model has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DriveKind {
    /// As the columns say.
    #[default]
    Auto,
    /// One spool; recorded fill and vent drives are combined to their difference.
    Spool,
    /// A fill and a vent valve with gains of their own; a recorded spool drive feeds both.
    Separate,
}

/// What is simulated for one channel, resolved from the choices and the columns that are there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Setup {
    /// The model.
    pub model: ModelKind,
    /// Drive kind of the valve; `None` for a regulator, which knows no valve.
    pub drive: Option<DriveKind>,
    /// Whether the board's loop is simulated.
    pub controller: bool,
}

impl Setup {
    /// Resolves the choices for `channel`.
    ///
    /// # Errors
    /// [`InputError`] when a drive is needed and neither recorded nor computable.
    pub fn resolve(
        model: ModelKind,
        controller: ControllerUse,
        drive: DriveKind,
        recording: &Recording,
        channel: &Channel,
        rig: &Rig,
    ) -> Result<Self, InputError> {
        if model.is_regulator() {
            return Ok(Self { model, drive: None, controller: false });
        }
        let rig = rig.at(channel.id);
        let recorded = channel.drive.as_ref();
        let closed = match controller {
            ControllerUse::On => true,
            ControllerUse::Off => false,
            ControllerUse::Auto => recorded.is_none(),
        };
        let able = rig.controller.is_some() && rig.sensor.is_some();
        if closed && !able {
            if recorded.is_none() {
                return Err(InputError::no_drive(recording, channel.id));
            }
            let table = if rig.controller.is_none() { "controller" } else { "sensor" };
            return Err(
                RigError::MissingTable { table, purpose: "the simulation of the board's loop" }.into()
            );
        }
        if !closed && recorded.is_none() {
            return Err(InputError::no_drive(recording, channel.id));
        }
        let drive = match (drive, recorded) {
            (DriveKind::Auto, Some(Drive::Separate { .. })) if !closed => DriveKind::Separate,
            (DriveKind::Auto, _) => DriveKind::Spool,
            (chosen, _) => chosen,
        };
        Ok(Self { model, drive: Some(drive), controller: closed })
    }

    /// What the inputs must hold for this.
    #[must_use]
    pub fn needs(self, pressure: bool) -> Needs {
        let regulator = self.model.is_regulator();
        Needs {
            command: regulator || self.controller,
            drive: !regulator && !self.controller,
            pneumatics: !regulator,
            pressure,
            start_kpa: 0.0,
            as_spool: self.drive == Some(DriveKind::Spool),
        }
    }

    pub(super) fn valve_drive(self) -> ValveDrive {
        if self.drive == Some(DriveKind::Separate) { ValveDrive::Separate } else { ValveDrive::Spool }
    }
}
