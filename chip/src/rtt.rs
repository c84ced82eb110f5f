//! Reads the log the way a debug probe does: from the first up channel of the RTT control block in
//! RAM.

use crate::bus::Bus;
use crate::report::Fault;

/// Layout of the control block: 16 bytes of identification, two counts, then the up channels: name,
/// buffer, size, write offset, read offset, flags.
const UP_BUFFERS: u32 = 24;
const BUFFER: u32 = UP_BUFFERS + 4;
const SIZE: u32 = UP_BUFFERS + 8;
const WRITE_OFFSET: u32 = UP_BUFFERS + 12;
const READ_OFFSET: u32 = UP_BUFFERS + 16;
const IDENTIFICATION: &[u8; 10] = b"SEGGER RTT";

/// Moves what is in the channel to the end of `log`. Does nothing while the block is not
/// initialised.
pub(crate) fn drain(bus: &mut Bus, control_block: u32, log: &mut Vec<u8>) -> Result<(), Fault> {
    for (i, expected) in (0..).zip(IDENTIFICATION) {
        if bus.read8(control_block + i)? != *expected {
            return Ok(());
        }
    }
    let buffer = bus.read32(control_block + BUFFER)?;
    let size = bus.read32(control_block + SIZE)?;
    let written = bus.read32(control_block + WRITE_OFFSET)?;
    let mut read = bus.read32(control_block + READ_OFFSET)?;
    if written >= size || read >= size {
        return Ok(());
    }
    while read != written {
        log.push(bus.read8(buffer + read)?);
        read = (read + 1) % size;
    }
    bus.write32(control_block + READ_OFFSET, read)
}
