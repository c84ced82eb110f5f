//! Blind tests of the diagnosis: cases that hide an effect, and the score of what was named.
//!
//! [`plan`] decides what is hidden and says it as arguments of the truth plant; it knows nothing of
//! the diagnosis. [`score`] sees `truth.json` and `report.json` and nothing else, and so does
//! [`table`], which compares what was said with what was said before. None uses another's crate:
//! the example `blind` and the tests `blind_rounds` bring them together.

pub mod diagram;
pub mod plan;
pub mod reliability;
pub mod score;
pub mod table;
