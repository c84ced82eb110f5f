//! Page requests: what a board can be asked besides its pressures. They command nothing.

use super::transaction::Question;
use super::{BoardFormat, Bus, ExchangeError};
use crate::line::{Line, LineError};
use pneudrive_protocol::pages::{
    About, Acceleration, AngularRate, Counter, Drives, Electronics, Entry, NO_SUCH_ENTRY, NowState,
    PageEntry, PostMortem, SensorEntry, SensorStatus, SupplyReading, number_in,
};
use pneudrive_protocol::{Address, PacketFormat, PageRequest};
use thiserror::Error;

/// A page request that brought no entry.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PageError {
    /// No answer came, or something else.
    #[error(transparent)]
    Exchange(#[from] ExchangeError),
    /// The board is spoken to in unchecked packets: it is of the original kind, or is not to be
    /// spoken to otherwise.
    #[error("{asked}: pages need checked packets; it is of the original kind, or --frames forbids them")]
    NotChecked {
        /// The board that was to be asked.
        asked: Address,
    },
    /// The board's firmware does not have this entry, or gave words that are none.
    #[error("{asked}: its firmware has no {entry:?}")]
    NoSuchEntry {
        /// The board that was asked.
        asked: Address,
        /// What it was asked for.
        entry: PageEntry,
    },
}

impl From<LineError> for PageError {
    fn from(error: LineError) -> Self {
        Self::Exchange(error.into())
    }
}

/// An entry of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PageReply {
    /// Its four words.
    pub words: Entry,
    /// When the request was handed to the line, ns on the line's clock.
    pub sent_ns: u64,
}

impl<L: Line> Bus<L> {
    /// Asks `board` for an entry of a page and waits for it, at most
    /// [`BusOptions::answer_timeout`](super::BusOptions::answer_timeout).
    ///
    /// Nothing is commanded: the board goes on with the set points it has, and its command timeout
    /// runs on. A board of which nothing is known is asked in checked packets; one of the original
    /// kind drops them and answers in its own.
    ///
    /// # Errors
    /// What came instead; that the board is not spoken to in checked packets; or that it does not
    /// have the entry. Firmware of before pages does not answer.
    pub fn page(&mut self, board: u8, entry: PageEntry) -> Result<PageReply, PageError> {
        let asked = Address::of_board(board);
        if self.format(board) == BoardFormat::Unchecked {
            return Err(PageError::NotChecked { asked });
        }
        self.wait_until_quiet(board)?;
        let now_ns = self.line.now_ns();
        let peer = &mut self.peers[usize::from(board)];
        let sequence = peer.negotiation.next_sequence();
        let plain = PageRequest::new(asked, entry, sequence);
        let request = peer.session.seal_page(now_ns).map_or(plain, |seal| plain.sealed(seal));
        let result = self.transact(Question::Page(request));
        let peer = &mut self.peers[usize::from(board)];
        peer.asked_for_page(result.is_ok());
        if let (Ok(_), Some(seal)) = (&result, request.seal) {
            peer.session.was_answered(seal.number());
        }
        match result {
            Ok(answer) => {
                peer.negotiation.answered(PacketFormat::Checked(sequence));
                match answer.pressures {
                    NO_SUCH_ENTRY => Err(PageError::NoSuchEntry { asked, entry }),
                    words => Ok(PageReply { words, sent_ns: answer.sent_ns }),
                }
            }
            Err(error) => {
                if matches!(error, ExchangeError::OriginalFormat { .. }) {
                    peer.negotiation.answered(PacketFormat::Unchecked);
                }
                // A late answer is known by its number, so the board is not left alone for it.
                if error.something_came() {
                    self.drain()?;
                }
                self.last_byte = None;
                Err(error.into())
            }
        }
    }

    /// The drives that `board`'s last control step gave its valves, and when it was asked, ns on
    /// the line's clock.
    ///
    /// # Errors
    /// As for [`page`](Self::page).
    pub fn drives(&mut self, board: u8) -> Result<(Drives, u64), PageError> {
        let reply = self.page(board, PageEntry::Drives)?;
        let drives = read(board, PageEntry::Drives, Drives::from_entry(reply.words))?;
        Ok((drives, reply.sent_ns))
    }

    /// What is on `board`'s I2C connector.
    ///
    /// # Errors
    /// As for [`page`](Self::page); [`PageError::NoSuchEntry`] from firmware of before sensors.
    pub fn sensors(&mut self, board: u8) -> Result<SensorStatus, PageError> {
        self.sensor(board, SensorEntry::Status, SensorStatus::from_entry).map(|(status, _)| status)
    }

    /// The supply pressure at `board`, and when it was asked, ns on the line's clock.
    ///
    /// # Errors
    /// As for [`sensors`](Self::sensors).
    pub fn supply(&mut self, board: u8) -> Result<(SupplyReading, u64), PageError> {
        self.sensor(board, SensorEntry::Supply, SupplyReading::from_entry)
    }

    /// What the accelerometer at `board` measures, and when it was asked, ns on the line's clock.
    ///
    /// # Errors
    /// As for [`sensors`](Self::sensors).
    pub fn acceleration(&mut self, board: u8) -> Result<(Acceleration, u64), PageError> {
        self.sensor(board, SensorEntry::Acceleration, Acceleration::from_entry)
    }

    /// What the gyroscope at `board` measures, and when it was asked, ns on the line's clock.
    ///
    /// # Errors
    /// As for [`sensors`](Self::sensors).
    pub fn angular_rate(&mut self, board: u8) -> Result<(AngularRate, u64), PageError> {
        self.sensor(board, SensorEntry::AngularRate, AngularRate::from_entry)
    }

    /// Temperature of the chip and voltage of the I2C connector at `board`, and when it was asked,
    /// ns on the line's clock.
    ///
    /// # Errors
    /// As for [`page`](Self::page); [`PageError::NoSuchEntry`] from firmware of before this page.
    pub fn electronics(&mut self, board: u8) -> Result<(Electronics, u64), PageError> {
        let reply = self.page(board, PageEntry::Electronics)?;
        Ok((read(board, PageEntry::Electronics, Electronics::from_entry(reply.words))?, reply.sent_ns))
    }

    fn sensor<T>(
        &mut self,
        board: u8,
        entry: SensorEntry,
        meaning: fn(Entry) -> Option<T>,
    ) -> Result<(T, u64), PageError> {
        let entry = PageEntry::Sensor(entry);
        let reply = self.page(board, entry)?;
        Ok((read(board, entry, meaning(reply.words))?, reply.sent_ns))
    }

    /// What `board` and its channels did in its last control step.
    ///
    /// # Errors
    /// As for [`page`](Self::page).
    pub fn board_state(&mut self, board: u8) -> Result<NowState, PageError> {
        let reply = self.page(board, PageEntry::State)?;
        read(board, PageEntry::State, NowState::from_entry(reply.words))
    }

    /// What `board` is.
    ///
    /// # Errors
    /// As for [`page`](Self::page).
    pub fn about(&mut self, board: u8) -> Result<About, PageError> {
        let reply = self.page(board, PageEntry::About)?;
        read(board, PageEntry::About, About::from_entry(reply.words))
    }

    /// What `board` has counted.
    ///
    /// # Errors
    /// As for [`page`](Self::page).
    pub fn counter(&mut self, board: u8, counter: Counter) -> Result<u32, PageError> {
        let entry = PageEntry::Counter(counter);
        let reply = self.page(board, entry)?;
        read(board, entry, number_in(reply.words))
    }

    /// Why `board`'s watchdog has reset it, if it has since power-on and the board knows. Each word
    /// that is lost is asked for up to `tries` times, at least once.
    ///
    /// # Errors
    /// As for [`page`](Self::page).
    pub fn post_mortem(&mut self, board: u8, tries: u32) -> Result<Option<PostMortem>, PageError> {
        let mut words = [0; PostMortem::WORDS];
        for (number, word) in (0..).zip(&mut words) {
            let entry = PageEntry::PostMortemWord(number);
            let mut reply = self.page(board, entry);
            for _ in 1..tries {
                if !matches!(reply, Err(PageError::Exchange(_))) {
                    break;
                }
                reply = self.page(board, entry);
            }
            *word = read(board, entry, number_in(reply?.words))?;
        }
        Ok(PostMortem::from_words(&words))
    }
}

fn read<T>(board: u8, entry: PageEntry, value: Option<T>) -> Result<T, PageError> {
    value.ok_or(PageError::NoSuchEntry { asked: Address::of_board(board), entry })
}
