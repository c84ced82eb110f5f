#![doc = include_str!("../README.md")]
//!
//! # How a recording passes through
//!
//! ```text
//! file -> source (plain, gzip, zstd; SHA-256) -> csv (cells to columns)
//!                                                or bag (messages to columns)
//!      -> quality (order, gaps, masks) -> Recording
//! ```
//!
//! [`load`] does it all, [`read`] the same for content in memory. What can be put right by leaving
//! samples out is left out and said in the [`QualityReport`]; what cannot be understood is a
//! [`DataError`] that names the file, the row as an editor counts it, and the column. [`series`] is
//! a channel of it as a simulation takes it: in Pa absolute, with what the [`rig`] file says.
//!
//! Each file format is a module that fills the same columns; [`load`] chooses by the first bytes of
//! the file.

mod bag;
mod channel;
mod column;
mod csv;
mod cut;
mod description;
mod error;
mod events;
mod flags;
mod follow;
pub mod import;
mod input_error;
mod inputs;
mod join;
mod live;
mod load;
pub mod quality;
mod recording;
pub mod rig;
mod source;
mod sparse;
mod thin;
pub mod write;

pub use bag::{BagError, RepairError, Repaired, repair};
pub use channel::ChannelId;
pub use column::ColumnKind;
pub use cut::CutError;
pub use description::{created_utc, rig_copy};
pub use error::{DataError, why};
pub use events::{Event, events};
pub use flags::Flags;
pub use input_error::InputError;
pub use inputs::{Needs, series};
pub use join::{JoinError, each_once, half_drives};
pub use live::{LiveTable, Opening};
pub use load::{LimitsOf, LoadOptions, Loaded, load, read};
pub use quality::{Finding, FindingKind, QualityReport, Sampling, SensorLimits, Span};
pub use recording::{BoardSupply, Channel, Drive, Joint, Recording};
pub use source::Source;
