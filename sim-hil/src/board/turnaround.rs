/// When a board's answer begins after the last stop bit of the request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turnaround {
    /// A fixed time later, ns: a board that answers from an interrupt.
    Fixed {
        /// From stop bit to start bit, ns.
        delay_ns: u64,
    },
    /// At the next turn of the board's main loop, which runs on by itself: the original, whose loop
    /// took 0.86 ms (1164 Hz with one board; Arduino loop, one look at the receive buffer a turn).
    OnceALoop {
        /// Period of the loop, ns.
        period_ns: u64,
    },
}

impl Turnaround {
    /// What the firmware on the RP2040 does: about 15 us from stop bit to start bit.
    pub const FIRMWARE: Self = Self::Fixed { delay_ns: 15_000 };
    /// The original's main loop.
    pub const ORIGINAL: Self = Self::OnceALoop { period_ns: 859_000 };

    /// When the answer to a request that ended at `request_end_ns` begins.
    pub fn answer_start_ns(self, request_end_ns: u64) -> u64 {
        match self {
            Self::Fixed { delay_ns } => request_end_ns + delay_ns,
            Self::OnceALoop { period_ns } => (request_end_ns / period_ns + 1) * period_ns,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Turnaround;

    #[test]
    fn the_originals_board_answers_at_its_next_turn() {
        let loops = Turnaround::OnceALoop { period_ns: 1_000 };
        assert_eq!([0, 1, 999, 1_000].map(|end| loops.answer_start_ns(end)), [1_000, 1_000, 1_000, 2_000]);
    }
}
