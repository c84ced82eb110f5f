//! What a user chooses about a simulation.

use serde::{Deserialize, Serialize};

use crate::board::Board;
use crate::data::{Channel, Drive, Recording};
use crate::model::{self, About, Constants, Listed, ValveDrive};
use crate::rig::{InputError, Needs, Rig, RigError};
use crate::rollout::{Chamber, System};

/// Makes the choice and what belongs to it from the list of models.
macro_rules! kinds {
    ($($name:ident),*) => {
        /// One of the models.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum ModelKind {
            $(#[doc = concat!("[`model::", stringify!($name), "`].")] $name,)*
        }

        impl ModelKind {
            /// All of them, in the paper's order.
            pub const ALL: [Self; [$(stringify!($name)),*].len()] = [$(Self::$name),*];

            /// What files, reports and the command line say of it.
            #[must_use]
            pub const fn about(self) -> &'static About {
                match self { $(Self::$name => &<model::$name as Listed>::ABOUT,)* }
            }

            /// The model with a rig's constants, behind a board's loop where there is one.
            pub(super) fn chamber(self, constants: &Constants, board: Option<Board>) -> Box<dyn System> {
                match self {
                    $(Self::$name => Box::new(Chamber { model: <model::$name as Listed>::of(constants), board }),)*
                }
            }
        }
    };
}
model::for_each_model!(kinds);

impl Default for ModelKind {
    fn default() -> Self {
        Self::Nonlinear
    }
}

impl ModelKind {
    /// Name in files and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.about().id
    }

    /// Does it describe a pressure loop along with the valve, driven by commands alone?
    #[must_use]
    pub const fn is_regulator(self) -> bool {
        self.about().is_regulator
    }
}

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
