//! Whether the adapter returns what it sends.
//!
//! Content cannot tell: a board that holds its set points answers with the very bytes of the
//! request. So a board is asked that does not exist; whatever comes back then is an echo.

use super::options::BusTimes;
use super::{BusOptions, FormatPolicy, HeardBytes, OpenBusError};
use crate::line::{Line, LineError};
use pneudrive_protocol::false_address::{GUARD, guard_pause_ns};
use pneudrive_protocol::{Address, CHANNELS, Counts, Echo, PACKET_LEN, Packet};
use thiserror::Error;

/// What comes back is neither nothing nor the request.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "a request to {asked}, which should not exist, was followed by {heard}, which is neither silence nor an echo; \
     another host on the bus, a babbling board, or another baud rate"
)]
#[non_exhaustive]
pub struct EchoError {
    /// The board that should not exist.
    pub asked: Address,
    /// What came.
    pub heard: HeardBytes,
}

/// Adapters may hold bytes back for 16 ms (FTDI's default); this is waited for once.
const ADAPTER_DELAY_NS: u64 = 20_000_000;
/// Tries before the line is declared unusable: noise may hit one.
const TRIES: usize = 3;

pub(super) fn detect(line: &mut impl Line, options: &BusOptions, unused: u8) -> Result<Echo, OpenBusError> {
    let asked = Address::of_board(unused);
    let request = Packet { address: asked, values: [Counts::ATMOSPHERE; CHANNELS] }.encode();
    let times = options.times();
    let mut heard = HeardBytes::default();
    for _ in 0..TRIES {
        if options.formats != FormatPolicy::Checked {
            // What was last on the wire is not known, and boards of the original kind may be there.
            line.send(&[GUARD])?;
            let until_ns = line.now_ns() + guard_pause_ns(options.baud);
            line.sleep_until(until_ns);
        }
        let wait_ns = times.answer_timeout_ns() + ADAPTER_DELAY_NS;
        line.send(&request)?;
        let deadline = line.now_ns() + wait_ns;
        heard = listen(line, deadline, &times)?;
        if heard.count() == 0 {
            return Ok(Echo::Absent);
        }
        // The guard comes back, too.
        let echo = heard.first().strip_prefix(&[GUARD]).unwrap_or(heard.first());
        if heard.count() <= PACKET_LEN + 1 && echo == request {
            return Ok(Echo::Present);
        }
    }
    Err(EchoError { asked, heard }.into())
}

/// Everything until the line is idle: until `deadline` for the first byte, then until a gap.
fn listen(line: &mut impl Line, deadline: u64, times: &BusTimes) -> Result<HeardBytes, LineError> {
    let mut heard = HeardBytes::default();
    let limit = deadline + times.drain_limit_ns();
    let mut until = deadline;
    while line.now_ns() < limit {
        let mut bytes = [0; 64];
        let count = line.receive(&mut bytes, 1, until)?;
        if count == 0 {
            break;
        }
        heard.extend(bytes[..count].iter().copied());
        until = (line.now_ns() + times.idle_ns()).max(deadline);
    }
    Ok(heard)
}
