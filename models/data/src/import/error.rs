//! What can go wrong in an import.

use crate::DataError;

/// A mapping that cannot be understood or a foreign file that does not fit it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// Reading or writing failed.
    #[error(transparent)]
    Data(#[from] DataError),
    /// A `--map` or `--time` text that does not parse.
    #[error("mapping \"{text}\": {problem}; expected {expected}, for example '{example}'")]
    Mapping {
        /// The text given.
        text: String,
        /// What is wrong with it.
        problem: String,
        /// The grammar.
        expected: &'static str,
        /// One that works.
        example: &'static str,
    },
    /// A target that is no column of the format.
    #[error(
        "mapping \"{text}\": {target} is not a column of the format; targets are b0_cmd0_kpa, b0_p0_kpa, b0_u0, b0_fill0, b0_vent0, b0_qu_rad, b0_qv_rad, b0_supply_kpa (any board and channel number) and supply_kpa"
    )]
    Target {
        /// The text given.
        text: String,
        /// The target in it.
        target: String,
    },
    /// A unit that the target's quantity cannot have.
    #[error(
        "mapping \"{text}\": {unit} is not a unit of {quantity}; use one of {allowed}, or a number: the value that stands for one {base}"
    )]
    Unit {
        /// The text given.
        text: String,
        /// The unit in it.
        unit: String,
        /// Pressure, drive, angle or time.
        quantity: &'static str,
        /// Units that would do.
        allowed: String,
        /// The unit of the target.
        base: &'static str,
    },
    /// Counts without a rig file that says what a count is.
    #[error("mapping \"{text}\": counts need {table} of the rig file; give it with --rig")]
    CountsWithoutRig {
        /// The text given.
        text: String,
        /// The table that says what a count is.
        table: &'static str,
    },
    /// Two mappings to one target.
    #[error("{target} is mapped twice; leave one of the mappings out")]
    MappedTwice {
        /// The target.
        target: String,
    },
    /// A source column that the file does not have.
    #[error(
        "{file}, row {line}: no column \"{column}\" among: {found}; names are compared exactly, #1 is the first column{hint}"
    )]
    NoSuchColumn {
        /// The file as given.
        file: String,
        /// The header's row.
        line: u64,
        /// The column asked for.
        column: String,
        /// The columns that are there.
        found: String,
        /// What may be wrong.
        hint: String,
    },
    /// A value that its target cannot have.
    #[error(transparent)]
    OutOfRange(Box<OutOfRange>),
}

/// A value that its target cannot have.
#[derive(Debug, thiserror::Error)]
#[error(
    "{file}, row {line}, column \"{column}\": {value} becomes {converted} in {target}, outside {low} to {high}; {advice}"
)]
pub struct OutOfRange {
    /// The file as given.
    pub file: String,
    /// Row.
    pub line: u64,
    /// Source column.
    pub column: String,
    /// The value in the file.
    pub value: f64,
    /// The value after conversion.
    pub converted: f64,
    /// Target column.
    pub target: String,
    /// Lowest allowed.
    pub low: f64,
    /// Highest allowed.
    pub high: f64,
    /// What to do.
    pub advice: &'static str,
}
