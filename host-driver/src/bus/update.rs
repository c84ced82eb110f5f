//! A new program for a board, over the bus.
//!
//! The board collects it in RAM while it goes on as before, writes it to flash when all of it is
//! there, and starts it on trial. It stays only if this host finds it, in a session, and confirms
//! it: see [`Update`].

mod end;
mod error;
mod progress;

pub use error::UpdateError;
pub use progress::{UpdateProgress, Updated};

use super::parameters::again;
use super::{Bus, ExchangeError, PageError};
use crate::line::Line;
use crate::program_file::ProgramFile;
use pneudrive_protocol::pages::{
    ChannelNow, PageEntry, Running, Update, UpdateAnswer, UpdateEntry, UpdateOutcome, UpdateReply,
    UpdateState, number_in,
};
use pneudrive_protocol::{Address, Counts};

/// Counts above atmosphere that a vented chamber's sensor may read: 17 kPa, as boards have it.
const VENTED_MARGIN: u16 = 20;
/// Bytes of a request.
const PIECE: usize = 3;
/// Requests that fail one after the other before the transfer does.
const TRIES: u32 = 20;
/// Commands between, so that the board does not take this host for dead: its command timeout can be
/// as short as 10 ms.
const COMMAND_NS: u64 = 4_000_000;
/// Progress is told so often.
const TELL_PIECES: usize = 256;

impl<L: Line> Bus<L> {
    /// Which program `board` runs, and what became of the last update.
    ///
    /// # Errors
    /// As for [`page`](Self::page); [`PageError::NoSuchEntry`] from firmware of before updates.
    pub fn update_state(&mut self, board: u8) -> Result<UpdateState, PageError> {
        let entry = PageEntry::Program(UpdateEntry::State);
        let words = self.page(board, entry)?.words;
        UpdateState::from_entry(words)
            .ok_or(PageError::NoSuchEntry { asked: Address::of_board(board), entry })
    }

    /// CRC-32 of the program that `board` runs; 0 if it is the one that was flashed.
    ///
    /// # Errors
    /// As for [`update_state`](Self::update_state).
    pub fn running_crc(&mut self, board: u8) -> Result<u32, PageError> {
        self.update_number(board, UpdateEntry::RunningCrc)
    }

    fn update_number(&mut self, board: u8, entry: UpdateEntry) -> Result<u32, PageError> {
        let entry = PageEntry::Program(entry);
        let words = self.page(board, entry)?.words;
        number_in(words).ok_or(PageError::NoSuchEntry { asked: Address::of_board(board), entry })
    }

    /// Brings `board` a new program and waits until it runs for good; tells `progress` meanwhile.
    /// Commands 0 kPa; the board must be vented when all has come, and vents until the end. A
    /// program of 64 KB takes some 6 s to send, and the board is away for a second and a half.
    ///
    /// # Errors
    /// Why the board goes on with the program that it had, or [`UpdateError::Lost`].
    pub fn update_board(
        &mut self,
        board: u8,
        file: &ProgramFile,
        mut progress: impl FnMut(UpdateProgress),
    ) -> Result<Updated, UpdateError> {
        let before = self.look_before_update(board, file)?;
        let is_there = matches!(before.running, Running::First | Running::Second);
        if is_there && again(|| self.running_crc(board))? == file.crc() {
            return Ok(Updated::Unchanged);
        }
        self.send_program(board, file, &mut progress).map_err(interrupted)?;
        progress(UpdateProgress::Writing);
        self.end_update(board, before, file.crc(), &mut progress)
    }

    /// Whether the board can be updated with this at all, in a session.
    fn look_before_update(&mut self, board: u8, file: &ProgramFile) -> Result<UpdateState, UpdateError> {
        let asked = Address::of_board(board);
        self.ping_again(board)?;
        let chip = again(|| self.about(board))?.chip;
        let state = match again(|| self.update_state(board)) {
            Err(PageError::NoSuchEntry { .. }) => return Err(UpdateError::TooOld { asked }),
            state => state?,
        };
        let wanted = file.program().chip;
        if state.running == Running::Unsupported {
            Err(UpdateError::Unsupported { asked, chip })
        } else if chip != wanted {
            Err(UpdateError::OtherChip { asked, chip, wanted })
        } else if state.running.is_trial() {
            Err(UpdateError::OnTrial { asked })
        } else if !self.in_session(board) {
            Err(UpdateError::NoSession { asked })
        } else if self.has_pressure(board)? {
            Err(UpdateError::NotVented { asked })
        } else {
            Ok(state)
        }
    }

    /// Whether the board would refuse the commit for it. It looks itself then; this is to save the
    /// time until then.
    fn has_pressure(&mut self, board: u8) -> Result<bool, UpdateError> {
        let channels = again(|| self.board_state(board))?.channels;
        let answer = self.ping(board)?;
        let limit = Counts::ATMOSPHERE.get() + VENTED_MARGIN;
        Ok(channels.iter().zip(answer.pressures).any(|(channel, pressure)| {
            matches!(channel, ChannelNow::Regulating | ChannelNow::Venting) && pressure.get() > limit
        }))
    }

    /// All pieces of the program and its CRC, each once: after a request that failed the board is
    /// asked how many have come.
    fn send_program(
        &mut self,
        board: u8,
        file: &ProgramFile,
        progress: &mut impl FnMut(UpdateProgress),
    ) -> Result<(), UpdateError> {
        let bytes = [file.bytes(), &file.crc().to_le_bytes()].concat();
        let pieces: Vec<Update> = bytes.chunks(PIECE).map(piece).collect();
        let of = file.bytes().len();
        self.begin_update(board)?;
        let (mut sent, mut failed) = (0, 0);
        let mut command_ns = 0;
        while let Some(piece) = pieces.get(sent) {
            if self.line.now_ns() >= command_ns {
                self.ping_again(board)?;
                command_ns = self.line.now_ns() + COMMAND_NS;
            }
            match self.update(board, *piece) {
                Ok(UpdateAnswer { reply: UpdateReply::Taken, received }) => {
                    sent = received as usize;
                    failed = 0;
                    if sent % TELL_PIECES == 0 {
                        progress(UpdateProgress::Sent { bytes: sent * PIECE, of });
                    }
                }
                Ok(answer) => return Err(refusal(board, answer.reply)),
                Err(PageError::Exchange(error))
                    if failed < TRIES && !matches!(error, ExchangeError::Line(_)) =>
                {
                    failed += 1;
                    sent = again(|| self.update_number(board, UpdateEntry::Received))? as usize;
                }
                Err(error) => return Err(error.into()),
            }
        }
        progress(UpdateProgress::Sent { bytes: of, of });
        Ok(())
    }

    /// Can be said twice.
    fn begin_update(&mut self, board: u8) -> Result<(), UpdateError> {
        for _ in 0..TRIES {
            self.ping_again(board)?;
            match self.update(board, Update::Begin) {
                Ok(UpdateAnswer { reply: UpdateReply::Taken, .. }) => return Ok(()),
                Ok(UpdateAnswer { reply: UpdateReply::NeedsSession, .. }) => {}
                Ok(answer) => return Err(refusal(board, answer.reply)),
                Err(PageError::Exchange(error)) if !matches!(error, ExchangeError::Line(_)) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Err(UpdateError::NoSession { asked: Address::of_board(board) })
    }

    fn update(&mut self, board: u8, update: Update) -> Result<UpdateAnswer, PageError> {
        let entry = PageEntry::Update(update);
        let words = self.page(board, entry)?.words;
        UpdateAnswer::from_entry(words)
            .ok_or(PageError::NoSuchEntry { asked: Address::of_board(board), entry })
    }
}

/// Why a board takes no part of a program.
fn refusal(board: u8, reply: UpdateReply) -> UpdateError {
    let asked = Address::of_board(board);
    match reply {
        UpdateReply::NotBegun => UpdateError::Forgotten { asked },
        UpdateReply::TooLong => UpdateError::Refused { asked, outcome: UpdateOutcome::NotAProgram },
        UpdateReply::Busy => UpdateError::Refused { asked, outcome: UpdateOutcome::Pending },
        UpdateReply::Taken | UpdateReply::NeedsSession | UpdateReply::Unsupported => {
            UpdateError::NoSession { asked }
        }
    }
}

fn interrupted(error: UpdateError) -> UpdateError {
    match error {
        UpdateError::Page(error) => UpdateError::Interrupted { error },
        error => error,
    }
}

fn piece(bytes: &[u8]) -> Update {
    Update::Bytes(std::array::from_fn(|n| bytes.get(n).copied().unwrap_or(0)))
}
