//! Recordings of the truth plant without a bus: what a host would have recorded, for fitting and
//! for blind tests.
//!
//! A [`Recorder`] runs a plant under an excitation, in closed loop with a board's control law or
//! with drives that are held from row to row, and yields one [`Row`] per exchange. [`write_csv`]
//! stores them in the measured-data format.
//!
//! ```
//! use pneudrive_sim::record::{Recorder, RecordingSettings};
//!
//! let settings = RecordingSettings { seconds: 0.5, ..RecordingSettings::default() };
//! let rows: Vec<_> = Recorder::new(&settings)?.collect();
//! assert_eq!(rows.len(), 50);
//! assert_eq!(rows[0].pressure_kpa.len(), 4);
//! # Ok::<(), pneudrive_sim::record::RecordError>(())
//! ```

mod board_law;
mod cli;
mod csv;
mod drive_pattern;
mod error;
mod excitation;
mod firmware_board;
mod ideal_board;
mod recorder;
mod rig;
mod schedule;
mod settings;

pub use self::board_law::BoardLaw;
pub use self::cli::RecordArgs;
pub use self::csv::write_csv;
pub use self::error::RecordError;
pub use self::excitation::{Excitation, SetPoints};
pub use self::firmware_board::FirmwareBoard;
pub use self::ideal_board::IdealBoard;
pub use self::recorder::{Recorder, Row};
pub(crate) use self::rig::nominal_toml;
pub use self::rig::rig_toml;
pub use self::settings::{BoardKind, Columns, ControlSettings, Loop, RecordingSettings};
