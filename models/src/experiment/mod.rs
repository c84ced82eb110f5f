//! Experiments on recordings: which model, on which part, how well, how fast.
//!
//! ```text
//! Recording + Rig -> Subject (model, drive kind, controller) + Series -> Fit on one part
//!     -> Score on another
//! ```
//!
//! [`compare()`] is the paper's experiment: the three models fitted on the first part of a
//! recording and judged on the rest.

mod compare;
mod fit;
mod judge;
mod kind;
mod page;
mod prepare;
mod result;
mod score;
mod split;
mod subject;
mod table;

pub use crate::rollout::ModelKind;
pub use compare::{CompareError, CompareSettings, CompareWatch, channels_at_once, compare};
pub use fit::{FitChannelsError, FitSettings, FittedChannel, fit_channels};
pub use kind::{ControllerUse, DriveKind, Setup};
pub use page::{Origin, comparison_page};
pub use prepare::{Prepared, prepare, simulation};
pub use result::{ChannelComparison, Comparison, ModelResult, Overall, Trace};
pub use score::{Sample, Score, score, score_rows, score_samples};
pub use split::{Split, SplitError};
pub use subject::{Objective, Subject, subject};
pub use table::comparison_text;
