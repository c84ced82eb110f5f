use pneudrive_sim::bus::Air;

/// Pressures that go up and down by 3 counts a millisecond, each sensor by itself: no physics, but
/// every answer differs from the one before and from every other board's.
#[derive(Debug, Default)]
pub(super) struct Waves;

impl Waves {
    /// Codes within the sensors' range, as 12-bit codes: 110 to 860 counts.
    const LOW: u64 = 440;
    const SPAN: u64 = 3_000;
    const CODES_PER_MS: u64 = 13;
}

impl Air for Waves {
    fn sample(&mut self, board: u8, now_ns: u64) -> [u16; 4] {
        std::array::from_fn(|channel| {
            let phase = u64::from(board) * 1_000 + channel as u64 * 371;
            let along = (now_ns / 1_000_000 * Self::CODES_PER_MS + phase) % (2 * Self::SPAN);
            (Self::LOW + along.min(2 * Self::SPAN - along)) as u16
        })
    }

    fn drive(&mut self, _board: u8, _now_ns: u64, _drives: [f64; 4]) {}
}
