//! Deviations of an interval's inputs from what is recorded.

/// Zeros with derivatives: the drive, the command and the volume as variables. The supply is one
/// anyway ([`Stepper::set_supply`](super::Stepper::set_supply)).
#[derive(Debug, Clone, Copy)]
pub struct Deviations<S> {
    /// Drive of the fill and the vent valve, -1 to 1; of one spool, the second is of no account.
    pub drive: [S; 2],
    /// The row's command, Pa.
    pub command: S,
    /// The command of the row before, which the first loop of a board still follows, Pa.
    pub command_before: S,
    /// Volume, m^3.
    pub volume: S,
    /// Its rate, m^3/s.
    pub volume_rate: S,
}
