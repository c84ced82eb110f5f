//! The host's side of a session with one board: asked for when the board is known to check, and
//! again when it has not answered.

use super::transaction::Question;
use super::{BoardFormat, Bus, ExchangeError};
use crate::line::Line;
use pneudrive_protocol::pages::{NO_SUCH_ENTRY, PageEntry, SessionOffer};
use pneudrive_protocol::{Address, PageRequest, RequestNumber, Seal, Session};

/// What a host knows of its session with one board.
#[derive(Debug, Clone)]
pub(super) struct HostSession {
    wanted: bool,
    state: State,
    /// Requests in a row that failed in the session.
    failures: u32,
    /// Requests for a session in a row that nobody answered.
    unanswered: u32,
    /// Requests that were sent without a session since.
    plain: u32,
    /// When it was last spoken to, ns.
    spoken_ns: u64,
}

#[derive(Debug, Clone, Copy)]
enum State {
    /// It has given none, and has not said that it knows none.
    None,
    /// Its firmware is of before sessions.
    NotKnown,
    Begun {
        session: Session,
        sent: RequestNumber,
        answered: RequestNumber,
    },
}

impl HostSession {
    /// After so many failures in a row the board may have been switched off and on, and know
    /// nothing of the session.
    const FAILURES: u32 = 2;
    /// Firmware of before pages does not answer. After so many tries it is asked again only after
    /// [`PLAIN`](Self::PLAIN) requests, because each costs a timeout.
    const TRIES: u32 = 3;
    const PLAIN: u32 = 1_000;
    /// A board that has heard nothing for its command timeout, 0.5 s unless its owner changed it,
    /// has ended the session. The host asks rather than lose the request that would find it out.
    const SILENCE_NS: u64 = 400_000_000;

    pub(super) fn new(wanted: bool) -> Self {
        Self { wanted, state: State::None, failures: 0, unanswered: 0, plain: 0, spoken_ns: 0 }
    }

    pub(super) fn current(&self) -> Option<Session> {
        match self.state {
            State::Begun { session, .. } => Some(session),
            State::None | State::NotKnown => None,
        }
    }

    fn has_begun(&self) -> bool {
        self.current().is_some()
    }

    /// Whether a session is to be asked for before the next request.
    fn is_due(&self, now_ns: u64) -> bool {
        self.wanted
            && match self.state {
                State::None => self.unanswered < Self::TRIES || self.plain >= Self::PLAIN,
                State::NotKnown => false,
                State::Begun { .. } => {
                    self.failures >= Self::FAILURES
                        || now_ns.saturating_sub(self.spoken_ns) >= Self::SILENCE_NS
                        || self.next().is_none()
                }
            }
    }

    fn next(&self) -> Option<Seal> {
        let State::Begun { session, sent, answered } = self.state else { return None };
        let number = sent.next();
        (number.since(answered) <= RequestNumber::WINDOW.into()).then(|| session.seal(number))
    }

    /// The seal of the next request; `None` if it goes without.
    pub(super) fn seal_request(&mut self, now_ns: u64) -> Option<Seal> {
        let next = self.next();
        self.spoken_ns = now_ns;
        if let (Some(seal), State::Begun { sent, .. }) = (next, &mut self.state) {
            *sent = seal.number();
        }
        self.plain = self.plain.saturating_add(1);
        next
    }

    /// The same for a page request. Those that are lost must not use up the window; and a board
    /// that has given a session is in it only when it has obeyed a command in it, and does not hear
    /// pages of it before.
    pub(super) fn seal_page(&mut self, now_ns: u64) -> Option<Seal> {
        let State::Begun { sent, answered, .. } = self.state else { return None };
        if answered == RequestNumber::default() {
            return None;
        }
        (sent.since(answered) < u32::from(RequestNumber::WINDOW) / 2).then(|| self.seal_request(now_ns))?
    }

    /// The request with this number was answered.
    pub(super) fn was_answered(&mut self, number: RequestNumber) {
        self.failures = 0;
        if let State::Begun { answered, .. } = &mut self.state {
            *answered = number;
        }
    }

    pub(super) fn failed(&mut self) {
        self.failures = self.failures.saturating_add(1);
    }

    /// The host has left.
    pub(super) fn end(&mut self) {
        *self = Self::new(self.wanted);
    }

    /// The board says that it gives this session.
    fn begin(&mut self, session: Session, now_ns: u64) {
        let zero = RequestNumber::default();
        *self = Self { spoken_ns: now_ns, ..Self::new(self.wanted) };
        self.state = State::Begun { session, sent: zero, answered: zero };
    }
}

impl<L: Line> Bus<L> {
    /// Whether `board` and this host are in a session: the board obeys each request once, and no
    /// other host's.
    pub fn in_session(&self, board: u8) -> bool {
        self.peers[usize::from(board)].session.current().is_some()
    }

    /// Whether `board` is to be asked for a session before the next request.
    pub(crate) fn session_is_due(&self, board: u8) -> bool {
        self.format(board) == BoardFormat::Checked
            && self.peers[usize::from(board)].session.is_due(self.line.now_ns())
    }

    /// Asks `board` for a session if that is due. A board that is in one already goes on with it.
    ///
    /// # Errors
    /// Nothing can be sent now: the board is in a session with another host, or it was in one with
    /// this host and does not answer.
    pub(super) fn ask_for_session(&mut self, board: u8) -> Result<(), ExchangeError> {
        if !self.session_is_due(board) {
            return Ok(());
        }
        let address = Address::of_board(board);
        let entry = PageEntry::Session(self.host_number);
        let sequence = self.peers[usize::from(board)].negotiation.next_sequence();
        let result = self.transact(Question::Page(PageRequest::new(address, entry, sequence)));
        let now_ns = self.line.now_ns();
        let peer = &mut self.peers[usize::from(board)];
        if result.is_ok() {
            peer.note_presence();
        }
        let session = &mut peer.session;
        match result.map(|answer| answer.pressures) {
            Ok(NO_SUCH_ENTRY) => session.state = State::NotKnown,
            Ok(words) => match SessionOffer::from_entry(words) {
                Some(SessionOffer::Number(number)) => session.begin(Session::new(address, number), now_ns),
                Some(SessionOffer::Busy) if session.next().is_some() => {
                    (session.failures, session.spoken_ns) = (0, now_ns)
                }
                Some(SessionOffer::Busy) => return Err(ExchangeError::InSession { asked: address }),
                None => session.state = State::NotKnown,
            },
            Err(error) => {
                let begun = session.has_begun();
                session.unanswered = session.unanswered.saturating_add(1);
                session.plain = 0;
                if error.something_came() {
                    self.drain()?;
                }
                self.last_byte = None;
                if begun || matches!(error, ExchangeError::Line(_)) {
                    return Err(error);
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn begun() -> HostSession {
        let mut session = HostSession::new(true);
        session.begin(Session::new(Address::of_board(0), 1), 0);
        session
    }

    fn number(session: &mut HostSession) -> Option<u32> {
        session.seal_request(0).map(|seal| seal.number().get())
    }

    #[test]
    fn requests_are_numbered_from_one_and_no_further_than_the_window() {
        let mut session = begun();
        let sent: Vec<_> = (0..9).map(|_| number(&mut session)).collect();
        assert_eq!(sent[..8], [1, 2, 3, 4, 5, 6, 7, 8].map(Some));
        assert!(sent[8].is_none() && session.is_due(0), "the board would not obey it");
        session.was_answered(RequestNumber::new(8));
        assert_eq!(number(&mut session), Some(9));
    }

    #[test]
    fn pages_leave_half_of_the_window_to_requests() {
        let mut session = begun();
        assert_eq!(session.seal_page(0), None, "the board is not in it so far");
        assert_eq!(number(&mut session), Some(1));
        session.was_answered(RequestNumber::new(1));
        let pages = (0..20).filter(|_| session.seal_page(0).is_some()).count();
        assert_eq!((pages, number(&mut session)), (4, Some(6)));
    }

    #[test]
    fn a_board_that_does_not_answer_is_asked_whether_it_still_has_the_session() {
        let mut session = begun();
        session.failed();
        assert!(!session.is_due(0));
        session.failed();
        assert!(session.is_due(0));
    }

    #[test]
    fn who_never_answers_is_asked_seldom() {
        let mut session = HostSession::new(true);
        let mut asked = Vec::new();
        for request in 0..2_500 {
            if session.is_due(0) {
                asked.push(request);
                (session.unanswered, session.plain) = (session.unanswered + 1, 0);
            }
            assert_eq!(number(&mut session), None);
        }
        assert_eq!(asked, [0, 1, 2, 1_002, 2_002]);
        assert!(!HostSession::new(false).is_due(0));
    }

    /// Two seconds of silence, as in a script that waits for something: the next request is not
    /// lost.
    #[test]
    fn after_its_own_silence_a_host_asks_before_it_commands() {
        let mut session = begun();
        session.seal_request(1_000_000_000).unwrap();
        assert!(!session.is_due(1_399_999_999));
        assert!(session.is_due(1_400_000_000));
    }
}
