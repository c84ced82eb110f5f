//! A faster line rate for a whole bus, and the way back.
//!
//! Boards are asked one after the other at the rate that they were compiled for; each goes to the
//! new one when it has answered, and back by itself when no request comes at it for 100 ms. So
//! whatever is lost on the way, everybody is at the compiled rate again after that time. Nothing of
//! it commands anything: set points stay, and a board's command timeout runs on.

use super::{BoardFormat, Bus, ExchangeError, PageError};
use crate::line::{Line, LineError};
use pneudrive_protocol::pages::{LineRate, LineRateAnswer, LineRateState, PageEntry};
use pneudrive_protocol::{Address, Baud};
use thiserror::Error;

/// What keeps a bus at the rate that its boards were compiled for.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum LineRateError {
    /// The port failed.
    #[error(transparent)]
    Line(#[from] LineError),
    /// A board of the original kind.
    #[error("{asked}: it is of the original kind, which has one line rate only")]
    Original {
        /// The board.
        asked: Address,
    },
    /// Its firmware does not know of line rates.
    #[error("{asked}: its firmware is of before line rates; flash a newer one")]
    OldFirmware {
        /// The board.
        asked: Address,
    },
    /// It obeys requests for a rate in a session only, and gives none.
    #[error("{asked}: it gives this host no session, in which alone line rates are changed")]
    NoSession {
        /// The board.
        asked: Address,
    },
    /// Its parameter forbids it.
    #[error("{asked}: its parameter max_baud does not allow a faster rate")]
    NotAllowed {
        /// The board.
        asked: Address,
    },
    /// The adapter rounds it to another rate, or refuses it.
    #[error("the adapter does not do {} baud", .baud.get())]
    Adapter {
        /// The rate.
        baud: Baud,
    },
    /// Too much was lost at the new rate.
    #[error("{asked} does not answer as it should at {} baud ({error}); its transceiver, its driver enable or the cable may be too slow", .baud.get())]
    Trial {
        /// The board.
        asked: Address,
        /// The rate.
        baud: Baud,
        /// How its last exchange failed.
        error: PageError,
    },
}

/// A request that is lost is sent again so often.
const TRIES: u32 = 3;
/// Rounds of requests to all boards at a new rate, of which so many may be lost.
const ROUNDS: u32 = 8;
const LOST_IN_TRIAL: u32 = 1;
/// What boards and adapter are given to change, ns: a board needs some 30 us after its answer.
const SETTLE_NS: u64 = 1_000_000;
/// Slow adapters get fewer rounds: boards wait for their commands meanwhile, ns.
const TRIAL_NS: u64 = 60_000_000;

impl<L: Line> Bus<L> {
    /// The line rate in effect, of host and boards.
    pub fn line_rate(&self) -> LineRate {
        self.line_rate
    }

    /// The same in bit/s.
    pub fn baud(&self) -> Baud {
        self.options.baud
    }

    /// The fastest line rate that all `boards` allow, and why it is no faster than that which they
    /// were compiled for, if it is not.
    ///
    /// # Errors
    /// The first board that does not allow any, and why.
    pub fn fastest_line_rate(&mut self, boards: &[u8]) -> Result<LineRate, LineRateError> {
        let mut fastest = LineRate::ThreeMbaud;
        for &board in boards {
            let asked = Address::of_board(board);
            let allowed = match self.line_rate_state(board) {
                Ok(state) => state.fastest,
                Err(PageError::NotChecked { .. }) => return Err(LineRateError::Original { asked }),
                Err(PageError::Exchange(ExchangeError::Line(error))) => return Err(error.into()),
                Err(_) => return Err(LineRateError::OldFirmware { asked }),
            };
            if allowed.baud(self.compiled) <= self.compiled {
                return Err(LineRateError::NotAllowed { asked });
            }
            if !self.in_session(board) {
                return Err(LineRateError::NoSession { asked });
            }
            fastest = fastest.min(allowed);
        }
        Ok(fastest)
    }

    /// Takes `boards`, which must be all on the bus, to `rate`: all of them, or none. Costs the
    /// time of some ten exchanges a board; if it fails, boards that were not told in time are
    /// silent for up to 100 ms.
    ///
    /// # Errors
    /// What keeps them from it. Host and boards are at the compiled rate then, or will be after 100
    /// ms.
    pub fn raise_line_rate(&mut self, boards: &[u8], rate: LineRate) -> Result<(), LineRateError> {
        self.ask_adapter(rate)?;
        let raised = self.ask_for_rate(boards, rate).and_then(|()| self.try_rate(boards, rate));
        if let Err(error) = &raised {
            log::debug!("line rate: {error}");
            self.lower_line_rate(boards)?;
        }
        raised
    }

    /// Takes `boards` and host back to the rate that they were compiled for. A board that does not
    /// hear it goes back by itself.
    ///
    /// # Errors
    /// Only when the line failed.
    pub fn lower_line_rate(&mut self, boards: &[u8]) -> Result<(), LineError> {
        if self.line_rate == LineRate::Compiled {
            return Ok(());
        }
        for &board in boards {
            for _ in 0..TRIES {
                match self.page(board, PageEntry::SetLineRate(LineRate::Compiled)) {
                    Err(PageError::Exchange(ExchangeError::Line(error))) => return Err(error),
                    Err(PageError::Exchange(_)) => {}
                    _ => break,
                }
            }
        }
        self.go_to(LineRate::Compiled).map(drop)
    }

    /// Whether the adapter does `rate`, before boards have gone there in vain.
    fn ask_adapter(&mut self, rate: LineRate) -> Result<(), LineRateError> {
        let possible = self.go_to(rate)?;
        self.go_to(LineRate::Compiled)?;
        if possible { Ok(()) } else { Err(LineRateError::Adapter { baud: rate.baud(self.compiled) }) }
    }

    /// Each board in turn. One whose answer is lost may have gone to the new rate already: the
    /// trial will tell.
    fn ask_for_rate(&mut self, boards: &[u8], rate: LineRate) -> Result<(), LineRateError> {
        for &board in boards {
            let asked = Address::of_board(board);
            for _ in 0..TRIES {
                let words = match self.page(board, PageEntry::SetLineRate(rate)) {
                    Ok(reply) => reply.words,
                    Err(PageError::Exchange(ExchangeError::Line(error))) => return Err(error.into()),
                    Err(PageError::Exchange(_)) => continue,
                    Err(PageError::NotChecked { .. }) => return Err(LineRateError::Original { asked }),
                    Err(PageError::NoSuchEntry { .. }) => return Err(LineRateError::OldFirmware { asked }),
                };
                match LineRateAnswer::from_entry(words) {
                    Some(LineRateAnswer::Taken) => break,
                    Some(LineRateAnswer::NeedsSession) => return Err(LineRateError::NoSession { asked }),
                    Some(LineRateAnswer::TooFast) => return Err(LineRateError::NotAllowed { asked }),
                    None => return Err(LineRateError::OldFirmware { asked }),
                }
            }
        }
        Ok(())
    }

    /// Requests to all boards in turn, so that none of them waits for its first one for long.
    fn try_rate(&mut self, boards: &[u8], rate: LineRate) -> Result<(), LineRateError> {
        let baud = rate.baud(self.compiled);
        if !self.go_to(rate)? {
            return Err(LineRateError::Adapter { baud });
        }
        self.line.sleep_until(self.line.now_ns() + SETTLE_NS);
        let started_ns = self.line.now_ns();
        let mut lost = 0;
        for round in 0..ROUNDS {
            if round > 0 && self.line.now_ns() - started_ns > TRIAL_NS {
                break;
            }
            for &board in boards {
                let error = match self.line_rate_once(board) {
                    Ok(state) if state.now == rate => continue,
                    Ok(_) => {
                        let (asked, entry) = (Address::of_board(board), PageEntry::LineRate);
                        PageError::NoSuchEntry { asked, entry }
                    }
                    Err(PageError::Exchange(ExchangeError::Line(error))) => return Err(error.into()),
                    Err(error) => error,
                };
                lost += 1;
                if lost > LOST_IN_TRIAL {
                    return Err(LineRateError::Trial { asked: Address::of_board(board), baud, error });
                }
            }
        }
        Ok(())
    }

    /// Sets the adapter. False if it cannot do the rate: then it is at the compiled one.
    pub(super) fn go_to(&mut self, rate: LineRate) -> Result<bool, LineError> {
        let baud = rate.baud(self.compiled);
        let done = self.line.change_baud(baud)?;
        let now = if done { rate } else { LineRate::Compiled };
        self.line_rate = now;
        self.set_baud(now.baud(self.compiled));
        // What comes from the time before is none of it.
        (self.emptied_ns, self.last_byte) = (None, None);
        Ok(done)
    }

    /// `board`'s line rate; what is lost is asked for again.
    ///
    /// # Errors
    /// As for [`page`](Self::page); [`PageError::NoSuchEntry`] from firmware of before line rates.
    pub fn line_rate_state(&mut self, board: u8) -> Result<LineRateState, PageError> {
        let mut result = self.line_rate_once(board);
        for _ in 1..TRIES {
            match &result {
                Err(PageError::Exchange(error)) if !matches!(error, ExchangeError::Line(_)) => {
                    if self.format(board) == BoardFormat::Unchecked {
                        return Err(PageError::NotChecked { asked: Address::of_board(board) });
                    }
                    result = self.line_rate_once(board);
                }
                _ => break,
            }
        }
        result
    }

    fn line_rate_once(&mut self, board: u8) -> Result<LineRateState, PageError> {
        let (asked, entry) = (Address::of_board(board), PageEntry::LineRate);
        let words = self.page(board, entry)?.words;
        LineRateState::from_entry(words).ok_or(PageError::NoSuchEntry { asked, entry })
    }
}
