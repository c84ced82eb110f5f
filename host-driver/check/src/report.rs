//! What a check found: what is shown, stored, and compared with next time.

use crate::Quantity;
use serde::{Deserialize, Serialize};

/// How well something is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// As it should be.
    Pass,
    /// It could not be measured; why is in [`Value::note`].
    NotMeasured,
    /// Somebody should look after it.
    Warn,
    /// It does not work as it should.
    Fail,
}

impl Verdict {
    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::NotMeasured => "not measured",
            Self::Warn => "warn",
            Self::Fail => "fail",
        }
    }
}

/// A quantity of a channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Value {
    /// What was measured.
    pub quantity: Quantity,
    /// Of which channel, 0 to 3.
    pub channel: usize,
    /// In the quantity's unit; `None` where it could not be measured.
    pub value: Option<f64>,
    /// Half the width of its 95 % interval, in the same unit.
    pub interval: Option<f64>,
    /// From where on it does not pass, as a range of values; `None` where that side has no limit.
    pub limits: (Option<f64>, Option<f64>),
    /// The same quantity in the earlier check.
    pub before: Option<f64>,
    /// How well it is for itself, without the earlier check.
    pub verdict_alone: Verdict,
    /// How well it is: the worse of that and of the comparison.
    pub verdict: Verdict,
    /// What is wrong, or why it could not be measured; empty where it passes.
    pub note: String,
}

/// One board.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoardReport {
    /// The board's number.
    pub board: u8,
    /// What was measured of its channels.
    pub values: Vec<Value>,
    /// Why the check was broken off; `None` if it was not.
    pub aborted: Option<String>,
    /// Whether that says nothing of the board: somebody ended the check, this machine stood still,
    /// or another board was the reason.
    #[serde(default)]
    pub unjudged: bool,
}

impl BoardReport {
    /// A check that was broken off because of this board.
    pub fn aborted(board: u8, why: impl Into<String>) -> Self {
        Self { board, values: Vec::new(), aborted: Some(why.into()), unjudged: false }
    }

    /// A check that was not done, or not to its end, for a reason that is not the board's.
    pub fn unjudged(board: u8, why: impl Into<String>) -> Self {
        Self { unjudged: true, ..Self::aborted(board, why) }
    }

    /// The worst of all.
    pub fn verdict(&self) -> Verdict {
        let worst = self.values.iter().map(|value| value.verdict).max().unwrap_or(Verdict::NotMeasured);
        if self.aborted.is_some() && !self.unjudged { Verdict::Fail } else { worst }
    }

    /// What warns or fails.
    pub fn problems(&self) -> impl Iterator<Item = &Value> {
        self.values.iter().filter(|value| value.verdict >= Verdict::Warn)
    }

    /// Whether anything warns or fails without the earlier check.
    pub fn alarms_alone(&self) -> bool {
        self.aborted.is_some() || self.values.iter().any(|value| value.verdict_alone >= Verdict::Warn)
    }

    /// A value by its quantity and channel.
    pub fn value(&self, quantity: Quantity, channel: usize) -> Option<&Value> {
        self.values.iter().find(|value| (value.quantity, value.channel) == (quantity, channel))
    }
}

/// A whole check. As JSON it is what `--json` prints and what is stored as baseline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// When it began, UTC (RFC 3339).
    pub started_utc: String,
    /// The port.
    pub port: String,
    /// Highest set point, kPa; channels with a lower limit went up to four fifths of that.
    pub level_kpa: f64,
    /// How many times as long as usual it took.
    pub stretch: f64,
    /// When the check was with which it was compared; `None` without one.
    pub baseline_utc: Option<String>,
    /// How well the rig is: the worst of its boards.
    pub verdict: Verdict,
    /// Each board.
    pub boards: Vec<BoardReport>,
}

impl Report {
    /// Version of its keys in JSON: it grows when one goes or changes its meaning.
    pub const SCHEMA: u32 = 1;

    /// A board by its number.
    pub fn board(&self, board: u8) -> Option<&BoardReport> {
        self.boards.iter().find(|one| one.board == board)
    }

    /// Whether it did not come to its end.
    pub fn was_broken_off(&self) -> bool {
        self.boards.iter().any(|board| board.aborted.is_some())
    }

    /// Whether values are missing because rows were late or missing: another check may have them.
    pub fn was_disturbed(&self) -> bool {
        let busy = crate::Missing::Busy.to_string();
        let mut values = self.boards.iter().flat_map(|board| &board.values);
        values.any(|value| value.value.is_none() && value.note == busy)
    }

    /// The worst of its boards.
    pub fn worst(boards: &[BoardReport]) -> Verdict {
        boards.iter().map(BoardReport::verdict).max().unwrap_or(Verdict::NotMeasured)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_board_that_is_the_reason_fails_with_a_check_that_is_broken_off() {
        let (lost, after) =
            (BoardReport::aborted(0, "does not answer"), BoardReport::unjudged(1, "not done"));
        assert_eq!((lost.verdict(), after.verdict()), (Verdict::Fail, Verdict::NotMeasured));
        assert_eq!(Report::worst(&[lost, after.clone()]), Verdict::Fail);
        assert_eq!(Report::worst(&[after]), Verdict::NotMeasured);
    }
}
