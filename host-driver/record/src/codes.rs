//! What is written for each of a board's 1024 codes.

use pneudrive_host::Calibration;
use pneudrive_protocol::{CHANNELS, Counts, SensorScale};

/// Something for every code of every channel, made once for each scale that occurs.
pub(super) struct Codes<T> {
    tables: Vec<(SensorScale, Vec<T>)>,
    /// Places in `tables`, of each board's channels.
    boards: Vec<[usize; CHANNELS]>,
}

impl<T> Codes<T> {
    /// `of` makes it from a channel's scale and a code.
    pub(super) fn new(
        boards: &[u8],
        calibration: &Calibration,
        of: impl Fn(&SensorScale, Counts) -> T,
    ) -> Self {
        let mut tables: Vec<(SensorScale, Vec<T>)> = Vec::new();
        let mut place = |scale: SensorScale| {
            tables.iter().position(|(known, _)| *known == scale).unwrap_or_else(|| {
                let codes = (0..=Counts::MAX.get()).map(Counts::saturating);
                tables.push((scale, codes.map(|counts| of(&scale, counts)).collect()));
                tables.len() - 1
            })
        };
        let boards = boards.iter().map(|&board| calibration.of(board).map(&mut place)).collect();
        Self { tables, boards }
    }

    /// That of a code of the board at `index`.
    pub(super) fn get(&self, index: usize, channel: usize, counts: Counts) -> &T {
        &self.tables[self.boards[index][channel]].1[usize::from(counts.get())]
    }
}
