//! How far an update is, and what it has done.

/// How far an update is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UpdateProgress {
    /// So many bytes are at the board.
    Sent {
        /// Bytes at the board.
        bytes: usize,
        /// Bytes of the program.
        of: usize,
    },
    /// The board writes it to flash and restarts.
    Writing,
    /// The new program has answered.
    Confirming,
}

/// What an update has done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Updated {
    /// The board runs this program already; nothing was sent.
    Unchanged,
    /// The board runs the new program, and will after every reset.
    Done,
}
