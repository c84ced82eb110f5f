use pneudrive_control::store::{Flash, RECORD, Slot};

/// A native board's flash: as long as the simulator runs.
#[derive(Debug, Clone)]
pub(super) struct MemoryFlash([[u8; RECORD]; 2]);

impl MemoryFlash {
    /// Erased.
    pub(super) fn new() -> Self {
        Self([[0xff; RECORD]; 2])
    }
}

impl Flash for MemoryFlash {
    fn read(&self, slot: Slot) -> [u8; RECORD] {
        self.0[slot.index()]
    }

    fn erase(&mut self, slot: Slot) -> bool {
        self.0[slot.index()] = [0xff; RECORD];
        true
    }

    fn program(&mut self, slot: Slot, record: &[u8; RECORD]) -> bool {
        for (byte, new) in self.0[slot.index()].iter_mut().zip(record) {
            *byte &= new;
        }
        true
    }
}
