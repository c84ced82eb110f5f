//! A cable that is too bad for fast line rates.

use pneudrive_host::line::{Line, LineError};
use pneudrive_protocol::Baud;

/// A cable or transceiver that damages bytes on their way to the host at fast rates.
#[derive(Debug)]
pub struct Cable<L> {
    /// What it leads to.
    pub line: L,
    baud: Baud,
    /// Rates from here on are damaged.
    pub from: Baud,
    /// One byte in so many.
    pub every: u64,
    /// The adapter does no faster rate.
    pub adapter_does: Baud,
    bytes: u64,
}

impl<L: Line> Cable<L> {
    /// It damages nothing before it is told to.
    pub fn sound(line: L) -> Self {
        Self {
            line,
            baud: Baud::ORIGINAL,
            from: Baud::ORIGINAL,
            every: u64::MAX,
            adapter_does: Baud::THREE_MBAUD,
            bytes: 0,
        }
    }
}

impl<L: Line> Line for Cable<L> {
    fn now_ns(&self) -> u64 {
        self.line.now_ns()
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        self.line.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wanted: usize, deadline_ns: u64) -> Result<usize, LineError> {
        let count = self.line.receive(into, wanted, deadline_ns)?;
        for byte in &mut into[..count] {
            self.bytes += 1;
            if self.baud >= self.from && self.bytes.is_multiple_of(self.every) {
                *byte ^= 0x10;
            }
        }
        Ok(count)
    }

    fn sleep_until(&mut self, at_ns: u64) {
        self.line.sleep_until(at_ns);
    }

    fn change_baud(&mut self, baud: Baud) -> Result<bool, LineError> {
        if baud > self.adapter_does {
            return self.line.change_baud(Baud::ORIGINAL).map(|_| false);
        }
        self.baud = baud;
        self.line.change_baud(baud)
    }
}
