//! A new program for a board, over the bus.
//!
//! The board collects it in RAM while it goes on as before, writes it to flash when all of it is there, and starts it on trial.
//! It stays only if this host finds it, in a session, and confirms it: see [`Update`].

use super::parameters::again;
use super::{Bus, ExchangeError, PageError};
use crate::line::{Line, LineError};
use crate::program_file::ProgramFile;
use pneudrive_protocol::pages::{
    ChannelNow, ChipKind, LastTrial, PageEntry, Running, Update, UpdateAnswer, UpdateEntry, UpdateOutcome,
    UpdateReply, UpdateState, number_in,
};
use pneudrive_protocol::{Address, Counts};
use thiserror::Error;

/// A board that was not updated. It goes on with the program that it had, except where [`Lost`](Self::Lost) says otherwise.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum UpdateError {
    /// It could not be asked.
    #[error(transparent)]
    Page(#[from] PageError),
    /// Its firmware is of before updates over the bus.
    #[error(
        "{asked}: its firmware is of before updates over the bus; flash it once with a debug probe (`cargo fw`) or by BOOTSEL (`cargo fw-uf2`)"
    )]
    TooOld {
        /// The board that was asked.
        asked: Address,
    },
    /// It cannot be updated over the bus at all.
    #[error("{asked}: {chip} is not updated over the bus; flash it with a debug probe or by BOOTSEL")]
    Unsupported {
        /// The board that was asked.
        asked: Address,
        /// What it runs on.
        chip: ChipKind,
    },
    /// The program is for another chip.
    #[error("{asked}: the program is for {wanted}, and the board is {chip}")]
    OtherChip {
        /// The board that was asked.
        asked: Address,
        /// What the board runs on.
        chip: ChipKind,
        /// What the program is for.
        wanted: ChipKind,
    },
    /// It gives no session, without which it takes no program.
    #[error(
        "{asked}: it gives this host no session, in which alone it takes a program; is another host on the bus?"
    )]
    NoSession {
        /// The board that was asked.
        asked: Address,
    },
    /// A program is on trial already.
    #[error(
        "{asked}: a program is on trial that nobody has confirmed; the board goes back to the one before within {} s, try again then",
        Update::TRIAL_S
    )]
    OnTrial {
        /// The board that was asked.
        asked: Address,
    },
    /// Its chambers have pressure.
    #[error(
        "{asked}: refused, because a chamber has more than 17 kPa; it is commanded 0 kPa, try again when it has vented"
    )]
    NotVented {
        /// The board that was asked.
        asked: Address,
    },
    /// It refused what it has received.
    #[error(
        "{asked}: refused what it has received ({outcome:?}); it goes on with the program that it had, try again"
    )]
    Refused {
        /// The board that was asked.
        asked: Address,
        /// Why.
        outcome: UpdateOutcome,
    },
    /// It is back with the old program.
    #[error("{asked}: {}; it is back with the program that it had", reason(.last_trial))]
    RolledBack {
        /// The board that was asked.
        asked: Address,
        /// How the trial ended.
        last_trial: LastTrial,
    },
    /// It took the program, and does not answer any more.
    #[error(
        "{asked}: it took the program and does not answer; a program on trial goes back within {} s, or when the board's supply is switched off and on",
        Update::TRIAL_S
    )]
    Lost {
        /// The board that was asked.
        asked: Address,
    },
}

fn reason(trial: &LastTrial) -> &'static str {
    match trial {
        LastTrial::None => "the new program was not started",
        LastTrial::Damaged => "its flash did not hold the new program, which was not started",
        LastTrial::NotConfirmed => "the new program did not answer",
    }
}

impl From<ExchangeError> for UpdateError {
    fn from(error: ExchangeError) -> Self {
        Self::Page(error.into())
    }
}

impl From<LineError> for UpdateError {
    fn from(error: LineError) -> Self {
        Self::Page(error.into())
    }
}

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

/// Counts above atmosphere that a vented chamber's sensor may read: 17 kPa, as boards have it.
const VENTED_MARGIN: u16 = 20;
/// Bytes of a request.
const PIECE: usize = 3;
/// Requests that fail one after the other before the transfer does.
const TRIES: u32 = 20;
/// Commands between, so that the board does not take this host for dead: its command timeout can be as short as 10 ms.
const COMMAND_NS: u64 = 4_000_000;
/// Progress is told so often.
const TELL_PIECES: usize = 256;
/// From a commit to the answer after the restart. At its worst flash takes 13 s for the longest program; usually it is one.
const WRITE_NS: u64 = 20_000_000_000;
/// From a confirmation to the answer after the restart.
const RESTART_NS: u64 = 3_000_000_000;
/// Between two questions whether it is there again.
const ASK_AGAIN_NS: u64 = 10_000_000;

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

    /// Brings `board` a new program and waits until it runs for good; tells `progress` meanwhile. Commands 0 kPa; the board must be
    /// vented when all has come, and vents until the end. A program of 64 KB takes some 6 s to send, and the board is away for
    /// a second and a half.
    ///
    /// # Errors
    /// Why the board goes on with the program that it had, or [`UpdateError::Lost`].
    pub fn update_board(
        &mut self,
        board: u8,
        file: &ProgramFile,
        mut progress: impl FnMut(UpdateProgress),
    ) -> Result<Updated, UpdateError> {
        let asked = Address::of_board(board);
        let before = self.look_before_update(board, file)?;
        let is_there = matches!(before.running, Running::First | Running::Second);
        if is_there && again(|| self.running_crc(board))? == file.crc() {
            return Ok(Updated::Unchanged);
        }
        self.send_program(board, file, before.outcome, &mut progress)?;
        progress(UpdateProgress::Writing);
        self.order(board, Update::Commit, before.outcome)?;
        let state = self.wait_for_program(board, WRITE_NS)?;
        if !state.running.is_trial() {
            let last_trial = state.last_trial;
            return Err(UpdateError::RolledBack { asked, last_trial });
        }
        progress(UpdateProgress::Confirming);
        // A session with the new program: it hears commands and answers them.
        self.ping_again(board)?;
        if !self.in_session(board) || again(|| self.running_crc(board))? != file.crc() {
            return Err(UpdateError::Lost { asked });
        }
        self.order(board, Update::Confirm, state.outcome)?;
        let state = self.wait_for_program(board, RESTART_NS)?;
        if state.running.is_trial() || again(|| self.running_crc(board))? != file.crc() {
            return Err(UpdateError::RolledBack { asked, last_trial: state.last_trial });
        }
        Ok(Updated::Done)
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

    /// Whether the board would refuse the commit for it. It looks itself then; this is to save the time until then.
    fn has_pressure(&mut self, board: u8) -> Result<bool, UpdateError> {
        let channels = again(|| self.board_state(board))?.channels;
        let answer = self.ping(board)?;
        let limit = Counts::ATMOSPHERE.get() + VENTED_MARGIN;
        Ok(channels.iter().zip(answer.pressures).any(|(channel, pressure)| {
            matches!(channel, ChannelNow::Regulating | ChannelNow::Venting) && pressure.get() > limit
        }))
    }

    /// All pieces of the program and its CRC, each once: after a request that failed the board is asked how many have come.
    fn send_program(
        &mut self,
        board: u8,
        file: &ProgramFile,
        before: UpdateOutcome,
        progress: &mut impl FnMut(UpdateProgress),
    ) -> Result<(), UpdateError> {
        let bytes = [file.bytes(), &file.crc().to_le_bytes()].concat();
        let pieces: Vec<Update> = bytes.chunks(PIECE).map(piece).collect();
        let of = file.bytes().len();
        self.order(board, Update::Begin, before)?;
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
                Ok(answer) => return Err(self.refusal(board, answer.reply)),
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

    /// Something that can be said twice, until it is answered. `before`: what the board has said of the update before this one.
    fn order(&mut self, board: u8, update: Update, before: UpdateOutcome) -> Result<(), UpdateError> {
        let mut refusal = UpdateReply::NeedsSession;
        for _ in 0..TRIES {
            self.ping_again(board)?;
            match self.update(board, update) {
                // Busy: the answer to the one before was lost.
                Ok(UpdateAnswer { reply: UpdateReply::Taken | UpdateReply::Busy, .. }) => return Ok(()),
                Ok(UpdateAnswer { reply: UpdateReply::NeedsSession, .. }) => {}
                Ok(answer) => {
                    refusal = answer.reply;
                    break;
                }
                // Lost, or the board restarts because of it.
                Err(PageError::Exchange(ExchangeError::NoAnswer { .. })) if update != Update::Begin => {
                    if self.is_obeyed(board, update, before) {
                        return Ok(());
                    }
                }
                Err(PageError::Exchange(error)) if !matches!(error, ExchangeError::Line(_)) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Err(self.refusal(board, refusal))
    }

    /// Whether a commit or a confirmation whose answer is missing has arrived: then the board works on it, or is silent because it
    /// restarts.
    fn is_obeyed(&mut self, board: u8, update: Update, before: UpdateOutcome) -> bool {
        match self.update_state(board) {
            Ok(state) => state.outcome != before || state.running.is_trial() == (update == Update::Commit),
            Err(PageError::Exchange(error)) => !error.something_came(),
            Err(_) => true,
        }
    }

    fn refusal(&mut self, board: u8, reply: UpdateReply) -> UpdateError {
        let asked = Address::of_board(board);
        match reply {
            UpdateReply::NotBegun | UpdateReply::TooLong => {
                UpdateError::Refused { asked, outcome: UpdateOutcome::Damaged }
            }
            UpdateReply::Busy => UpdateError::Refused { asked, outcome: UpdateOutcome::Pending },
            UpdateReply::Taken | UpdateReply::NeedsSession | UpdateReply::Unsupported => {
                UpdateError::NoSession { asked }
            }
        }
    }

    fn update(&mut self, board: u8, update: Update) -> Result<UpdateAnswer, PageError> {
        let entry = PageEntry::Update(update);
        let words = self.page(board, entry)?.words;
        UpdateAnswer::from_entry(words)
            .ok_or(PageError::NoSuchEntry { asked: Address::of_board(board), entry })
    }

    /// What the board says after its restart, or why it does not restart.
    fn wait_for_program(&mut self, board: u8, within_ns: u64) -> Result<UpdateState, UpdateError> {
        let asked = Address::of_board(board);
        let until_ns = self.line.now_ns() + within_ns;
        while self.line.now_ns() < until_ns {
            match self.update_state(board) {
                Ok(state) => match state.outcome {
                    UpdateOutcome::None => {
                        self.peers[usize::from(board)].session.end();
                        return Ok(state);
                    }
                    UpdateOutcome::Pending => {}
                    UpdateOutcome::NotVented => return Err(UpdateError::NotVented { asked }),
                    outcome => return Err(UpdateError::Refused { asked, outcome }),
                },
                // Not in the session any more, if it has restarted.
                Err(PageError::Exchange(ExchangeError::Line(error))) => return Err(error.into()),
                Err(_) => self.peers[usize::from(board)].session.end(),
            }
            self.line.sleep_until(self.line.now_ns() + ASK_AGAIN_NS);
        }
        Err(UpdateError::Lost { asked })
    }
}

fn piece(bytes: &[u8]) -> Update {
    Update::Bytes(std::array::from_fn(|n| bytes.get(n).copied().unwrap_or(0)))
}
