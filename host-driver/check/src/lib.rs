//! Self-test of a board: commands that show what its valves, chambers and sensors are like, what is
//! measured of the answers, and whether that is well, for itself and beside an earlier check.
//!
//! ```text
//!   Plan ──set points over time──▶ (somebody's bus) ──readings──▶ Samples ──measure──▶ Value
//!   Value, earlier Report ──judge──▶ BoardReport
//! ```
//!
//! Nothing here knows of a bus or reads a clock. All pressures are kPa gauge, all times seconds of
//! the plan.
//!
//! ```
//! use pneudrive_check::{Plan, Quantity, Samples, judge, measure};
//!
//! let plan = Plan::new([150.0; 4], 1.0)?;
//! let mut samples = Samples::default();
//! // A board whose sensors read 0 whatever it is commanded.
//! for row in 0..(plan.seconds() / 0.002) as u32 {
//!     let t_s = f64::from(row) * 0.002;
//!     let command = plan.command_kpa(t_s, &samples);
//!     samples.push(t_s, command, [0.0; 4]);
//! }
//! let board = judge(0, measure(&plan, &samples), None);
//! assert!(board.problems().any(|value| value.quantity == Quantity::Reached));
//! # Ok::<(), pneudrive_check::PlanError>(())
//! ```
#![forbid(unsafe_code)]

mod compare;
mod judge;
mod line_fit;
mod measure;
mod missing;
mod page;
mod plan;
mod quantity;
mod report;
mod samples;
mod table;

pub use judge::judge;
pub use measure::{Measured, completed, measure};
pub use missing::Missing;
pub use page::page;
pub use plan::{Plan, PlanError};
pub use quantity::{Quantity, Unit};
pub use report::{BoardReport, Report, Value, Verdict};
pub use samples::Samples;
pub use table::{problems, table};

/// Channels of a board.
pub const CHANNELS: usize = 4;
