//! The same library as an FMI 3.0 unit for co-simulation: `pneudrive-model export fmu` puts it into
//! a zip with a parameter file.
//!
//! Names and types are those of the standard (fmi-standard.org, 3.0.1). What a unit of this kind
//! does not have (model exchange, clocks, other types of variables) answers `fmi3Error`.

// What an importer passes across the border cannot be checked by the compiler, and the names are
// the standard's.
#![allow(unsafe_code, non_snake_case)]

mod absent;
mod functions;
mod states;
mod unit;
