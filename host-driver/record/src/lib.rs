//! Recordings of what boards measure, in the measured-data format, without the bus ever waiting for
//! the disk.
//!
//! One row per bus cycle: `t_s`, `b{n}_cmd{k}_kpa`, `b{n}_p{k}_kpa`. Pressures are what the boards
//! sent, unfiltered; a board that gave no answer in a cycle leaves its pressure cells empty,
//! because an old value is no measurement. A command is the one last sent, as it was sent: rounded
//! to a count. What boards are asked for in pages ([`PageColumns`]) stands behind, in the rows of
//! the cycles in which they were asked. In a file named `.mcap` the same rows are messages of a ROS
//! 2 bag.
//!
//! A recording says of itself when, with what and how it was made ([`Description`]), and holds what
//! happened meanwhile: in a table as comment lines `# key: value` whose values are JSON, in a bag
//! as a metadata record and messages of `rcl_interfaces/msg/Log`.
//!
//! The [`Recorder`] (on the bus thread) collects rows for some ms and hands them to a thread that
//! writes them. That thread appends a complete block of whole rows twice a second; in a compressed
//! file each block is a gzip member or zstd frame of its own, in a bag a chunk. So the file is
//! readable as it is at any time, and `kill -9` costs at most the last second. A block that could
//! only be written in part (full disk) is taken back.
//!
//! Beside the recorder:
//!
//! - [`Contents`]: what a recording says of itself, and [`replay`]: its rows, looked at again.
//! - [`trajectory`]: set points from a file, a recording for example.
//! - [`watch`]: rows to a program that runs beside, and what it says of them.
//! - [`messages`]: those of ROS 2, in bags and of the ROS node.
#![forbid(unsafe_code)]

mod bag;
mod codes;
mod contents;
mod description;
mod error;
mod file;
mod format;
pub mod messages;
mod notes;
mod recorder;
pub mod replay;
mod rows;
mod sensor_columns;
mod stored;
mod switch;
pub mod trajectory;
pub mod watch;
mod writable;
mod writer;

pub use contents::{Contents, ContentsEvent};
pub use description::{Description, PageColumns, RecorderOptions};
pub use error::RecordError;
pub use format::FileFormat;
pub use notes::Notes;
pub use recorder::{RecordedBus, Recorder, RecordingSummary};
pub(crate) use rows::{Batch, Formatter};
pub use switch::{RecordSwitch, SwitchError, SwitchStatus};
pub use writable::{file_is_writable, folder_is_writable};
