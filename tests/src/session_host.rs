//! What a host says to one board, within its session once it has one.

use pneudrive_protocol::pages::{Entry, PageEntry, SessionOffer};
use pneudrive_protocol::{
    Address, AnswerDecoder, CheckedPacket, Direction, Echo, Heard, PageRequest, RequestNumber, Sequence,
    Session,
};

use crate::chip_bench::{Answer, packet};

/// A host's side of a session with one board; without one at first.
#[derive(Debug, Clone)]
pub struct SessionHost {
    /// The board.
    pub board: u8,
    session: Option<(Session, RequestNumber)>,
}

impl SessionHost {
    /// Without a session.
    #[must_use]
    pub fn new(board: u8) -> Self {
        Self { board, session: None }
    }

    /// Begins the session that a board has offered.
    ///
    /// # Panics
    /// When these words offer none.
    pub fn begin(&mut self, words: Entry) {
        match SessionOffer::from_entry(words) {
            Some(SessionOffer::Number(number)) => {
                let session = Session::new(Address::of_board(self.board), number);
                self.session = Some((session, RequestNumber::default()));
            }
            other => panic!("{other:?}"),
        }
    }

    /// A command in a checked packet.
    #[must_use]
    pub fn command(&mut self, commands: [u16; 4]) -> [u8; 10] {
        let packet = packet(self.board, commands);
        match &mut self.session {
            None => CheckedPacket { packet, sequence: Sequence::new(1) }.encode(Direction::Request),
            Some((session, number)) => {
                *number = number.next();
                let checked = CheckedPacket { packet, sequence: number.sequence() };
                checked.encode_sealed(Direction::Request, session.seal(*number))
            }
        }
    }

    /// A request for an entry of a page.
    #[must_use]
    pub fn request(&mut self, entry: PageEntry) -> PageRequest {
        let plain = PageRequest::new(Address::of_board(self.board), entry, Sequence::new(3));
        match &mut self.session {
            None => plain,
            Some((session, number)) => {
                *number = number.next();
                plain.sealed(session.seal(*number))
            }
        }
    }
}

/// The words of an answer to a request for an entry.
///
/// # Panics
/// When it is no answer to that.
#[must_use]
pub fn words_of(request: PageRequest, answer: &Answer) -> Entry {
    let mut decoder = AnswerDecoder::for_page(request, Echo::Absent);
    match answer.bytes().into_iter().find_map(|byte| decoder.push(byte)) {
        Some(Heard::Answer(words)) => words,
        other => panic!("{request:?}: {other:?}"),
    }
}
