use super::port::VirtualPort;
use super::report::PaceReport;
use super::{Delivery, SimError};
use crate::bus::{Bus, HostByte};

/// Bytes on their way from the bus to the client: kept until their run ends or the FIFO is full.
#[derive(Debug)]
pub(super) struct OutputFifo {
    fifo: usize,
    run: Vec<u8>,
    newest_ns: u64,
    late_sum_us: f64,
    last: Delivery,
}

impl OutputFifo {
    pub fn new(fifo: usize) -> Self {
        Self { fifo, run: Vec::new(), newest_ns: 0, late_sum_us: 0.0, last: Delivery::default() }
    }

    /// Takes what the bus has for the host, and writes what is due. `now_ns` says what time it is
    /// when it is written.
    pub fn step(
        &mut self,
        bus: &mut Bus,
        port: &VirtualPort,
        report: &mut PaceReport,
        now_ns: impl Fn() -> u64,
    ) -> Result<(), SimError> {
        while let Some(HostByte { at_ns, byte, .. }) = bus.receive() {
            self.run.push(byte);
            self.newest_ns = at_ns;
            if self.run.len() >= self.fifo {
                self.write(port, report, now_ns())?;
            }
        }
        if !self.run.is_empty() && bus.is_quiet() {
            self.write(port, report, now_ns())?;
        }
        Ok(())
    }

    /// The last time that something was handed over.
    pub fn last(&self) -> Delivery {
        self.last
    }

    /// Forgets what nobody is there to read.
    pub fn forget(&mut self) {
        self.run.clear();
    }

    fn write(&mut self, port: &VirtualPort, report: &mut PaceReport, now_ns: u64) -> Result<(), SimError> {
        let unread = port.write(&self.run).map_err(SimError::pty("write to"))?;
        report.overrun_bytes += unread as u64;
        self.run.clear();
        self.last = Delivery { at_ns: now_ns, late_ns: now_ns.saturating_sub(self.newest_ns) };
        let late_us = self.last.late_ns as f64 / 1e3;
        report.handed_over += 1;
        self.late_sum_us += late_us;
        report.late_mean_us = self.late_sum_us / report.handed_over as f64;
        report.late_max_us = report.late_max_us.max(late_us);
        Ok(())
    }
}
