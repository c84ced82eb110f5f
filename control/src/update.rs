//! A new program as it comes over the bus, until the board's runner takes it.
//!
//! The program itself the runner keeps: it takes each piece right after the byte that completed the
//! request ([`BusPort::take_piece`](crate::BusPort::take_piece)). What is here counts pieces and
//! says what may happen when.

pub mod choice;

use pneudrive_protocol::pages::{
    ChipKind, Entry, LastTrial, Running, Update, UpdateAnswer, UpdateEntry, UpdateOutcome, UpdateReply,
    UpdateState, number_entry,
};
use pneudrive_protocol::program::{LONGEST, Program, ProgramError, crc};

/// Bytes of a piece.
pub const PIECE: usize = 3;
/// Bytes that a runner must be able to keep: the longest program and its CRC, in whole pieces.
pub const INBOX: usize = (LONGEST + 4).next_multiple_of(PIECE);

/// The program that a board runs, as its pages say it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunningProgram {
    /// Which it is.
    pub running: Running,
    /// How the last trial since power-on ended, if not by a confirmation.
    pub last_trial: LastTrial,
    /// Its CRC-32, 0 if it is as flashed.
    pub crc: u32,
}

/// Three bytes of a new program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Piece {
    /// Where they belong, less than [`INBOX`].
    pub offset: usize,
    /// The bytes.
    pub bytes: [u8; PIECE],
}

/// What a host wants of the board's runner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UpdateOrder {
    /// To [`check`] what has come, to keep it and to restart with it on trial.
    Try {
        /// Bytes that have come.
        received: usize,
    },
    /// To keep the program on trial for good, and to restart.
    Keep,
}

/// The program at the beginning of what has come, whose CRC follows it.
///
/// # Errors
/// What to tell the host.
pub fn check(received: &[u8], chip: ChipKind) -> Result<Program, UpdateOutcome> {
    let program = Program::parse(received).map_err(|error| match error {
        ProgramError::NotAProgram | ProgramError::Vectors { .. } | ProgramError::Length { .. } => {
            UpdateOutcome::NotAProgram
        }
    })?;
    let (body, rest) = received.split_at_checked(program.length).ok_or(UpdateOutcome::Damaged)?;
    if rest.first_chunk() != Some(&crc(body).to_le_bytes()) {
        return Err(UpdateOutcome::Damaged);
    }
    if program.chip == chip { Ok(program) } else { Err(UpdateOutcome::OtherChip) }
}

/// What of an update its pages say and change. Answers must leave within 20 us.
#[derive(Debug, Clone)]
pub(crate) struct UpdateDesk {
    program: RunningProgram,
    /// Pieces since an update was begun, if one was.
    received: Option<u32>,
    /// The one that came last, until the runner has it.
    piece: Option<Piece>,
    order: Option<UpdateOrder>,
    outcome: UpdateOutcome,
}

impl UpdateDesk {
    pub(crate) const fn unsupported() -> Self {
        Self::new(RunningProgram { running: Running::Unsupported, last_trial: LastTrial::None, crc: 0 })
    }

    pub(crate) const fn new(program: RunningProgram) -> Self {
        Self { program, received: None, piece: None, order: None, outcome: UpdateOutcome::None }
    }

    pub(crate) fn entry(&self, entry: UpdateEntry) -> Entry {
        match entry {
            UpdateEntry::State if self.program.running == Running::Unsupported => {
                UpdateState::UNSUPPORTED.to_entry()
            }
            UpdateEntry::State => UpdateState {
                outcome: self.outcome,
                running: self.program.running,
                last_trial: self.program.last_trial,
                longest_kib: (LONGEST / 1024) as u16,
            }
            .to_entry(),
            UpdateEntry::Received => number_entry(self.received.unwrap_or(0)),
            UpdateEntry::RunningCrc => number_entry(self.program.crc),
        }
    }

    /// Obeys what came in a session, or not. Apart from the other entries, which would be slower
    /// for it.
    #[inline(never)]
    pub(crate) fn update(&mut self, update: Update, in_session: bool) -> UpdateAnswer {
        let reply = self.obey(update, in_session);
        UpdateAnswer { reply, received: self.received.unwrap_or(0) }
    }

    #[inline]
    fn obey(&mut self, update: Update, in_session: bool) -> UpdateReply {
        if self.program.running == Running::Unsupported {
            return UpdateReply::Unsupported;
        }
        if !in_session {
            return UpdateReply::NeedsSession;
        }
        if self.outcome == UpdateOutcome::Pending {
            return UpdateReply::Busy;
        }
        // First what comes most: a board has 20 us for its answer.
        if let (Update::Bytes(bytes), Some(pieces)) = (update, &mut self.received) {
            let offset = *pieces as usize * PIECE;
            if offset >= INBOX {
                return UpdateReply::TooLong;
            }
            *pieces += 1;
            self.piece = Some(Piece { offset, bytes });
            return UpdateReply::Taken;
        }
        match (update, &mut self.received) {
            // The old program is what a trial falls back to: nothing is written over it.
            (Update::Begin, _) if self.program.running.is_trial() => return UpdateReply::NotBegun,
            (Update::Begin, received) => *received = Some(0),
            (Update::Commit, Some(pieces)) => {
                self.order = Some(UpdateOrder::Try { received: *pieces as usize * PIECE });
                self.outcome = UpdateOutcome::Pending;
            }
            (Update::Confirm, _) if self.program.running.is_trial() => {
                self.order = Some(UpdateOrder::Keep);
                self.outcome = UpdateOutcome::Pending;
            }
            (Update::Bytes(_) | Update::Commit | Update::Confirm, _) => return UpdateReply::NotBegun,
        }
        UpdateReply::Taken
    }

    /// The piece that came last, once.
    #[inline]
    pub(crate) fn take_piece(&mut self) -> Option<Piece> {
        self.piece.take()
    }

    /// What a host wants done, once.
    pub(crate) fn take_order(&mut self) -> Option<UpdateOrder> {
        self.order.take()
    }

    /// Why it is not done. What has come is forgotten.
    pub(crate) fn end(&mut self, outcome: UpdateOutcome) {
        self.outcome = outcome;
        self.received = None;
    }

    /// The host has left or fallen silent. A commit that it has made goes on.
    pub(crate) fn forget(&mut self) {
        if self.outcome != UpdateOutcome::Pending {
            self.received = None;
        }
    }
}

#[cfg(test)]
mod tests;
