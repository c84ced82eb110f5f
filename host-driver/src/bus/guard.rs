//! What keeps a board 0 of the original kind from hearing its address where it is not meant.

use super::{BoardFormat, Bus, ExchangeError};
use crate::line::{Line, LineError};
use pneudrive_protocol::false_address::{self, GUARD};
use pneudrive_protocol::{AnswerDecoder, CHANNELS, CheckedPacket, Counts, Echo};

/// Guards in a row before one request, where bytes that nobody asked for keep ending in 0xFF.
const TRIES: usize = 3;

impl<L: Line> Bus<L> {
    /// The commands that [`exchange`](Self::exchange) sends for `commands`, as things stand: the
    /// same, but channel 3's is one count (0.84 kPa) lower if it is 255, 511, 767 or 1023 and board
    /// 0 may be of the original kind. Such a board would take the request's last byte and the first
    /// one of what follows for its own address.
    ///
    /// Four commands of 0 counts have a meaning of their own ([`leave`](Self::leave)): then the
    /// first one is sent as 1 count, which vents as well.
    pub fn commands_on_the_wire(&self, mut commands: [Counts; CHANNELS]) -> [Counts; CHANNELS] {
        if commands == CheckedPacket::LEAVE {
            commands[0] = Counts::saturating(1);
        }
        if self.board_0_may_misread() { false_address::without_false_address(commands) } else { commands }
    }

    /// Whether board 0 may be of the original kind: only a board that has answered in checked
    /// packets is not.
    fn board_0_may_misread(&self) -> bool {
        self.format(0) != BoardFormat::Checked
    }

    /// Makes the line ready for a request: nothing that came unasked is left, and no 0xFF stands
    /// before it. Says whether the echo of a guard byte may still come.
    pub(super) fn prepare(&mut self) -> Result<bool, ExchangeError> {
        let mut echo_due = false;
        for _ in 0..TRIES {
            self.expect_silence()?;
            if !self.board_0_may_misread() || !false_address::needs_guard(self.last_byte) {
                break;
            }
            echo_due = self.send_guard()?;
        }
        Ok(echo_due)
    }

    fn send_guard(&mut self) -> Result<bool, LineError> {
        let until_ns = self.line.now_ns() + false_address::guard_pause_ns(self.options.baud);
        self.line.send(&[GUARD])?;
        self.last_byte = Some(GUARD);
        let mut echo = [0; 1];
        let echoed = match self.echo {
            Echo::Absent => 0,
            Echo::Present => self.line.receive(&mut echo, 1, until_ns)?,
        };
        self.line.sleep_until(until_ns);
        // Some adapters keep an echo for milliseconds.
        Ok(self.echo == Echo::Present && echoed == 0)
    }
}

/// Tells `decoder` that the echo of a guard byte may come first.
pub(super) fn with_guard(decoder: AnswerDecoder, echo_due: bool) -> AnswerDecoder {
    if echo_due { decoder.after_guard() } else { decoder }
}
