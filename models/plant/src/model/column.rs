//! The layout of one row of inputs. What holds for the interval from this row's time stamp to the
//! next one's.
//!
//! Systems of several channels repeat the block per channel; a system that needs more appends
//! columns of its own after [`COUNT`].

/// Time stamp of the row, s.
pub const TIME_S: usize = 0;
/// Length of the interval, s, positive.
pub const INTERVAL_S: usize = 1;
/// Fill drive: the spool's drive `u` (-1 to 1), or the fill valve's (0 to 1).
pub const FILL: usize = 2;
/// Vent drive: minus the spool's drive, or the vent valve's (0 to 1).
pub const VENT: usize = 3;
/// Commanded pressure, absolute, Pa.
pub const COMMAND_PA: usize = 4;
/// Supply pressure, absolute, Pa, mean over the interval.
pub const SUPPLY_PA: usize = 5;
/// One by the mean of the chamber volume over the interval, 1/m^3: the models divide by the volume,
/// and a batch in lanes would feel it.
pub const INVERSE_VOLUME_PER_M3: usize = 6;
/// Rate of the chamber volume, m^3/s: its change over the interval by the interval's length.
pub const VOLUME_RATE_M3_S: usize = 7;
/// Number of standard columns.
pub const COUNT: usize = 8;
