//! A poller's newest row as the page shows it.

use pneudrive_host::Calibration;
use pneudrive_host::poller::{BoardRow, BoardState, Commanding, Override, OverrideError, Snapshot};
use pneudrive_page::{BoardMoment, Moment, ReadingMoment, Refusal};
use pneudrive_protocol::Counts;

/// The newest cycle at `now_ns` on the clock of its rows; `None` before the first.
pub(super) fn of(
    snapshot: &Snapshot,
    now_ns: u64,
    calibration: &Calibration,
    overriding: Option<&Override>,
) -> Option<Moment> {
    Some(Moment {
        cycle: snapshot.cycle?,
        since_start_ns: snapshot.since_start_ns,
        age: snapshot.age(now_ns)?,
        commanding: commanding(overriding),
        release_returns: overriding.is_some_and(Override::returns),
        boards: snapshot.boards.iter().map(|row| board(row, now_ns, calibration)).collect(),
    })
}

/// Whose commands the boards get, in the page's words; nobody commands a recording.
pub(super) fn commanding(overriding: Option<&Override>) -> pneudrive_page::Commanding {
    let Some(overriding) = overriding else { return pneudrive_page::Commanding::Recording };
    match overriding.commanding() {
        Commanding::Following => pneudrive_page::Commanding::Trajectory,
        Commanding::Vented => pneudrive_page::Commanding::Vented,
        Commanding::Manual => pneudrive_page::Commanding::SetPoints,
    }
}

/// Why a set point was not taken.
pub(super) fn refusal(error: &OverrideError) -> Refusal {
    match error {
        OverrideError::Vented | OverrideError::Following => Refusal::Conflict(error.to_string()),
        _ => Refusal::Unusable(error.to_string()),
    }
}

fn state(state: BoardState) -> pneudrive_page::BoardState {
    match state {
        BoardState::Unseen => pneudrive_page::BoardState::Unseen,
        BoardState::Present => pneudrive_page::BoardState::Present,
        BoardState::Doubtful => pneudrive_page::BoardState::Doubtful,
        BoardState::Missing => pneudrive_page::BoardState::Missing,
    }
}

fn board(row: &BoardRow, now_ns: u64, calibration: &Calibration) -> BoardMoment {
    BoardMoment {
        state: state(row.state),
        command_kpa: calibration.command_kpa(row.board, row.command),
        target_kpa: calibration.command_kpa(row.board, row.wanted),
        supply_kpa: row.sensors.supply.and_then(|supply| supply.shown_kpa(now_ns)),
        chip_c: row.sensors.electronics.and_then(|electronics| electronics.shown_chip_c(now_ns)),
        reading: row.reading.map(|reading| ReadingMoment {
            age: reading.age(now_ns),
            kpa: reading.kpa,
            // Boards answer the first or the last code for a sensor that cannot be right.
            faulty: reading.counts.map(|counts| [Counts::MIN, Counts::MAX].contains(&counts)),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneudrive_host::poller::{
        BoardSensors, ElectronicsReading, Outcome, Reading, SupplyPressure, VENTED,
    };
    use std::time::Duration;

    /// The poller's states and the page's have the same names, in figures and pictures, and none is
    /// left over.
    #[test]
    fn states_are_the_same_on_both_sides() {
        use pneudrive_page::BoardState as Page;
        for page in [Page::Unseen, Page::Present, Page::Doubtful, Page::Missing] {
            // Without a wildcard: a state that the page gets one day has to be the poller's too.
            let host = match page {
                Page::Unseen => BoardState::Unseen,
                Page::Present => BoardState::Present,
                Page::Doubtful => BoardState::Doubtful,
                Page::Missing => BoardState::Missing,
            };
            assert_eq!(state(host), page);
            assert_eq!(serde_json::to_value(host).unwrap(), serde_json::to_value(page).unwrap());
        }
    }

    #[test]
    fn commands_set_points_and_pressures_in_kpa() {
        let calibration = Calibration::default();
        let counts = [102, 221, 0, 1023].map(|value| Counts::new(value).unwrap());
        let row = BoardRow {
            board: 0,
            command: [Counts::ATMOSPHERE, Counts::saturating(221), VENTED[0], Counts::MAX],
            wanted: [Counts::saturating(340), Counts::saturating(221), VENTED[0], Counts::MAX],
            outcome: Outcome::Fresh,
            reading: Some(Reading { counts, kpa: calibration.kpa(0, counts), asked_ns: 1_000 }),
            drives: None,
            sensors: BoardSensors {
                supply: Some(SupplyPressure { kpa: 549.66, measured_ns: 1_000 }),
                electronics: Some(ElectronicsReading { chip_c: Some(41.3), rail_v: None, asked_ns: 1_000 }),
                ..BoardSensors::default()
            },
            state: BoardState::Doubtful,
        };
        let snapshot = Snapshot { cycle: Some(7), at_ns: 900, since_start_ns: 800, boards: vec![row] };
        let overriding = Override::manual(&[VENTED]);
        let moment = of(&snapshot, 1_500, &calibration, Some(&overriding)).unwrap();
        assert_eq!((moment.cycle, moment.since_start_ns, moment.age), (7, 800, Duration::from_nanos(600)));
        assert_eq!(moment.commanding, pneudrive_page::Commanding::SetPoints);
        let board = moment.boards[0];
        assert_eq!(board.state, pneudrive_page::BoardState::Doubtful);
        let tenths = |kpa: [f64; 4]| kpa.map(|kpa| (kpa * 10.0).round() as i32);
        assert_eq!(tenths(board.command_kpa), [0, 998, 0, 7748]);
        assert_eq!(tenths(board.target_kpa), [2000, 998, 0, 7748]);
        let reading = board.reading.unwrap();
        assert_eq!((reading.age, reading.faulty), (Duration::from_nanos(500), [false, false, true, true]));
        assert_eq!(tenths(reading.kpa)[1], 998);
        assert_eq!((board.supply_kpa, board.chip_c), (Some(549.66), Some(41.3)));
        let later = of(&snapshot, 11_000_000_000, &calibration, None).unwrap();
        assert_eq!((later.boards[0].supply_kpa, later.boards[0].chip_c), (None, None), "they are old");
        overriding.vent();
        assert_eq!(commanding(Some(&overriding)), pneudrive_page::Commanding::Vented);
        assert!(of(&Snapshot::default(), 0, &calibration, None).is_none(), "before the first cycle");
    }
}
