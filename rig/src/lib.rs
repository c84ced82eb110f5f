//! The rig file: one TOML file that describes a machine to everything that works with it.
//!
//! ```text
//!   format (all tables and keys) ──▶ reader ──▶ Rig ──▶ host, page, ROS node, Python, toolkit
//!             └──▶ JSON schema, for editors
//! ```
//!
//! The format is one table, from which the reader, its messages and the schema come. Unknown
//! tables and keys are refused with their line: a misspelt limit must not be no limit.
//!
//! ```
//! use pneudrive_rig::{Rig, Unit};
//!
//! let rig = Rig::parse("rig.toml", "
//! [display]
//! unit = \"bar\"
//! [limits]
//! max_kpa = 300
//! [boards.0]
//! name = \"shoulder\"
//! [boards.0.channels.3.limits]
//! max_kpa = 100
//! ")?;
//! assert_eq!(rig.limit(0, 2).max_kpa, Some(300.0));
//! assert_eq!(rig.limit(0, 3).max_kpa, Some(100.0));
//! assert_eq!(rig.board_name(0), Some("shoulder"));
//! assert_eq!(rig.unit(), Unit::Bar);
//!
//! let refused = Rig::parse("rig.toml", "[limits]\nmax_pka = 300\n").unwrap_err();
//! assert_eq!(refused.to_string(), "rig.toml:2: unknown key limits.max_pka; did you mean max_kpa?");
//! # Ok::<(), pneudrive_rig::RigError>(())
//! ```
//!
//! This crate knows nothing of the bus and of models: it says what the file says.
#![forbid(unsafe_code)]

#[cfg(feature = "edit")]
mod edit;
mod error;
mod format;
mod read;
mod rig;
mod schema;
mod unit;

#[cfg(feature = "edit")]
pub use edit::{NewRig, with_sensor};
pub use error::RigError;
pub use rig::{Bus, Limit, Rig, Sensor};
pub use schema::schema;
pub use unit::Unit;

/// Channels of a board.
pub const CHANNELS: usize = 4;
