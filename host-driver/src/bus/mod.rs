//! One exchange with one board, and what keeps the next one right when it fails.
//!
//! A board is spoken to in checked packets if it understands them ([`FormatPolicy::Negotiate`]): a
//! CRC guards the values, and a sequence number tells whose answer an answer is (it repeats after
//! 16 requests; no board answers the first of them after the last). A board that knows sessions
//! gives one, in which it obeys each request once, and no other host ([`Bus::in_session`]). Boards
//! of the original kind answer unchecked packets, which do not say which request they belong to.
//! With those, three rules keep a late answer from being taken for that to a later request:
//!
//! 1. Before a request the line is looked at; bytes that nobody asked for are discarded until the
//!    line is idle.
//! 2. After a failed exchange, what still comes is discarded until the line is idle.
//! 3. A board that did not answer may still do so: it is left alone until its answer would be too
//!    late to be believed ([`BusOptions::late_answer_limit`]; twice the longest delay seen from
//!    this board lately, if that is more). Other boards can be asked meanwhile, because answers
//!    carry their board's address. When 100 answers have told how late this board's answers really
//!    are, it is asked again within that time. As long as the limit lasts, its answers are then
//!    believed only if they come when this board's answers come, and no other follows.
//!
//! What a board can be asked besides its pressures is in [`pages`](Bus::page).
//!
//! As long as board 0 may be of the original kind, nothing on the wire can be taken for its address
//! where that is not meant ([`false_address`](pneudrive_protocol::false_address)): some set points
//! of channel 3 are sent one count lower ([`Bus::commands_on_the_wire`]), and a byte 0x00 goes
//! before a request that would follow 0xFF.

mod delays;
mod echo;
mod error;
mod format;
mod guard;
mod heard;
mod line_rate;
mod options;
mod pages;
mod parameters;
mod peer;
mod safe_state;
mod session;
mod transaction;
mod update;
mod usual_delay;

pub use echo::EchoError;
pub use error::{ExchangeError, OpenBusError};
pub use format::{BoardFormat, FormatPolicy};
pub use heard::HeardBytes;
pub use line_rate::LineRateError;
pub use options::{BusOptions, EchoMode};
pub use pages::{PageError, PageReply};
pub use parameters::{ChangeFrom, ParameterChange, ParameterError};
pub use peer::Counters;
pub use safe_state::SafeStateOptions;
pub use update::{UpdateError, UpdateProgress, Updated};

use crate::line::{Line, SerialPort};
use format::FormatNegotiation;
use options::BusTimes;
use peer::Peer;
use pneudrive_protocol::pages::{LineRate, SessionOffer};
use pneudrive_protocol::{Address, Baud, CHANNELS, Counts, Echo, Packet, PacketFormat, Sequence};
use std::path::Path;
use std::time::Duration;
use transaction::Question;

/// What a board answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Answer {
    /// Measured pressures of channels 0 to 3, ADC counts.
    pub pressures: [Counts; CHANNELS],
    /// When the request was handed to the line, ns on the line's clock. The board measured after at
    /// most one of its loops before this: a value's age counts from here.
    pub sent_ns: u64,
    /// When the last byte of the answer had been read, ns on the line's clock.
    pub answered_ns: u64,
}

impl Answer {
    /// Time from request to answer as the host saw it.
    pub fn round_trip(&self) -> Duration {
        Duration::from_nanos(self.round_trip_ns())
    }

    pub(crate) fn round_trip_ns(&self) -> u64 {
        self.answered_ns - self.sent_ns
    }
}

/// The bus, seen from its master.
#[derive(Debug)]
pub struct Bus<L: Line = SerialPort> {
    line: L,
    /// Its `baud` is that of the rate in effect.
    options: BusOptions,
    /// Those of `options`.
    times: BusTimes,
    /// The rate that the boards were compiled for.
    compiled: Baud,
    line_rate: LineRate,
    echo: Echo,
    peers: Vec<Peer>,
    unsolicited_bytes: u64,
    /// When the line was last read empty, ns, if nothing has been sent since.
    emptied_ns: Option<u64>,
    /// What it asks for sessions with, 0 to 101: a [`random`](Line::random) number of this run.
    host_number: u8,
    /// The last byte on the wire, if it is known.
    last_byte: Option<u8>,
}

impl Bus<SerialPort> {
    /// Opens a serial port for this process alone and finds out whether it echoes.
    ///
    /// # Errors
    /// The port cannot be used, or the line is not quiet enough to tell whether it echoes.
    pub fn open(port: impl AsRef<Path>, options: BusOptions) -> Result<Self, OpenBusError> {
        Self::new(SerialPort::open(port.as_ref(), options.serial())?, options)
    }
}

impl<L: Line> Bus<L> {
    /// A bus on any line.
    ///
    /// # Errors
    /// The line failed, or is not quiet enough to tell whether it echoes.
    pub fn new(mut line: L, options: BusOptions) -> Result<Self, OpenBusError> {
        let echo = match options.echo {
            EchoMode::Known(echo) => echo,
            EchoMode::Detect { unused_board } => echo::detect(&mut line, &options, unused_board)?,
        };
        line.expect_bytes(transaction::expected_bytes(echo));
        let times = options.times();
        let peer =
            Peer::new(times.late_answer_limit_ns, FormatNegotiation::new(options.formats), options.sessions);
        let peers = vec![peer; usize::from(u8::MAX) + 1];
        let host_number = (line.random() % u32::from(SessionOffer::HOST_NUMBERS)) as u8;
        Ok(Self {
            line,
            compiled: options.baud,
            line_rate: LineRate::Compiled,
            options,
            times,
            echo,
            peers,
            unsolicited_bytes: 0,
            emptied_ns: None,
            host_number,
            last_byte: None,
        })
    }

    /// After the line failed: tries once to open it again. What was known of the boards' packet
    /// formats and of the echo is found out anew, because the adapter or the boards may be others
    /// now; what has been counted stays.
    ///
    /// # Errors
    /// As for [`new`](Self::new); it can be tried again.
    pub fn reopen(&mut self) -> Result<(), OpenBusError> {
        self.line.reopen()?;
        self.line_rate = LineRate::Compiled;
        self.set_baud(self.compiled);
        if let EchoMode::Detect { unused_board } = self.options.echo {
            self.echo = echo::detect(&mut self.line, &self.options, unused_board)?;
        }
        self.line.expect_bytes(transaction::expected_bytes(self.echo));
        self.emptied_ns = None;
        self.last_byte = None;
        for peer in &mut self.peers {
            peer.renew(FormatNegotiation::new(self.options.formats), self.options.sessions);
        }
        Ok(())
    }

    /// Asks `board` whether it is there, and which packets it understands if that is not known yet:
    /// then up to three times, in both formats. There is no other request than one with commands: a
    /// ping commands 0 kPa, which vents.
    ///
    /// # Errors
    /// As for [`exchange`](Self::exchange).
    pub fn ping(&mut self, board: u8) -> Result<Answer, ExchangeError> {
        let mut result = self.exchange(board, [self.options.vent; CHANNELS]);
        for _ in 0..FormatNegotiation::CHECKED_TRIES {
            let again = match &result {
                Ok(_) | Err(ExchangeError::Line(_)) => false,
                Err(ExchangeError::OriginalFormat { .. }) => true,
                Err(_) => self.format(board) == BoardFormat::Unknown,
            };
            if !again {
                break;
            }
            result = self.exchange(board, [self.options.vent; CHANNELS]);
        }
        // Firmware of before pages does not answer when it is asked for a session: found out here,
        // it costs no command its time.
        while result.is_ok() && self.session_is_due(board) {
            self.wait_until_quiet(board)?;
            self.ask_for_session(board)?;
        }
        result
    }

    /// Sends four commands to `board` and waits for its four pressures, at most
    /// [`BusOptions::answer_timeout`]. What is sent are the
    /// [`commands_on_the_wire`](Self::commands_on_the_wire).
    ///
    /// Waits first where the board may still answer an earlier request;
    /// [`ready_at_ns`](Self::ready_at_ns) tells until when.
    ///
    /// # Errors
    /// What came instead of the answer, or that nothing came. The bus can be used on after any of
    /// them but a line error.
    pub fn exchange(&mut self, board: u8, commands: [Counts; CHANNELS]) -> Result<Answer, ExchangeError> {
        self.request(board, self.commands_on_the_wire(commands))
    }

    /// An exchange with `values` as they are.
    fn request(&mut self, board: u8, values: [Counts; CHANNELS]) -> Result<Answer, ExchangeError> {
        self.wait_until_quiet(board)?;
        let request = Packet { address: Address::of_board(board), values };
        self.peers[usize::from(board)].note_command(&values);
        let started_ns = self.line.now_ns();
        let (format, result) = match self.ask_for_session(board) {
            Ok(()) => {
                let peer = &mut self.peers[usize::from(board)];
                let seal = peer.session.seal_request(started_ns);
                let format = seal.map_or_else(|| peer.negotiation.next(), PacketFormat::Sealed);
                (format, self.transact(Question::Pressures(request, format)))
            }
            Err(error) => (PacketFormat::Checked(Sequence::default()), Err(error)),
        };
        let peer = &mut self.peers[usize::from(board)];
        match &result {
            Ok(answer) => {
                peer.answered(format, answer.round_trip_ns());
            }
            Err(error) => {
                // A late checked answer is known by its number.
                let owes = format == PacketFormat::Unchecked && !error.answer_consumed();
                peer.failed(error, owes.then_some(started_ns), self.times.answer_timeout_ns());
                if error.something_came() {
                    self.drain()?;
                }
                // What the boards heard may not be what the host heard, and a board of the original
                // kind that has waited in vain for the rest of a request goes on with the byte
                // before.
                self.last_byte = None;
            }
        }
        result
    }

    /// From when on `board` can be asked without waiting, ns on the line's clock.
    pub fn ready_at_ns(&self, board: u8) -> u64 {
        self.peers[usize::from(board)].quiet_until_ns()
    }

    /// Which packets `board` understands.
    pub fn format(&self, board: u8) -> BoardFormat {
        self.peers[usize::from(board)].negotiation.known()
    }

    /// What has happened between host and `board` so far.
    pub fn counters(&self, board: u8) -> Counters {
        self.peers[usize::from(board)].counters()
    }

    /// Whether an answer of `board` was ever accepted. What is damaged or comes late does not tell
    /// whose it is: that of another board can fall into the time of one that does not exist.
    pub fn was_seen(&self, board: u8) -> bool {
        self.peers[usize::from(board)].was_seen()
    }

    /// Bytes heard while nobody had been asked.
    pub fn unsolicited_bytes(&self) -> u64 {
        self.unsolicited_bytes
    }

    /// Whether the adapter returns what it sends.
    pub fn echo(&self) -> Echo {
        self.echo
    }

    /// The settings it was made with, and the line rate in effect.
    pub fn options(&self) -> &BusOptions {
        &self.options
    }

    /// The times of its settings at the line rate in effect.
    pub(crate) fn times(&self) -> &BusTimes {
        &self.times
    }

    fn set_baud(&mut self, baud: Baud) {
        self.options.baud = baud;
        self.times = self.options.times();
    }

    /// The line below.
    pub fn line(&self) -> &L {
        &self.line
    }

    /// Lets go of the line.
    pub fn into_line(self) -> L {
        self.line
    }

    /// The line below, to sleep on.
    pub fn line_mut(&mut self) -> &mut L {
        &mut self.line
    }
}
