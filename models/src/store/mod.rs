//! Parameter files: fitted parameters as TOML, with where they came from, and back.

mod error;
mod file;
mod provenance;

pub use error::StoreError;
pub use file::{ChannelParameters, ParameterFile, Settings, StoredParameter};
pub use provenance::{Provenance, RigSource};
