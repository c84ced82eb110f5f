//! What the result says: causes with sizes, what has earned a name, the verdict, the extended
//! model.

pub mod alternatives;
pub mod beside;
mod causes;
pub mod earned;
mod extended;
pub mod probable;
pub mod verdict;

pub use causes::measured_causes;
pub use extended::{ExtendedChannel, ExtendedFile, SCHEMA as EXTENDED_SCHEMA, band_holds, extended_file};
