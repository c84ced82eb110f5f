//! The models by name.

use serde::{Deserialize, Serialize};

use super::{Chamber, System};
use crate::board::Board;
use crate::model::{self, About, Constants, Listed};

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
            #[must_use]
            pub fn chamber(self, constants: &Constants, board: Option<Board>) -> Box<dyn System> {
                match self {
                    $(Self::$name => Box::new(Chamber { model: <model::$name as Listed>::of(constants), board }),)*
                }
            }
        }
    };
}
crate::model::for_each_model!(kinds);

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
