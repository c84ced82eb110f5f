//! The interrupt controller (B3.4): 26 interrupt lines of the RP2040 on 32 inputs, four priorities,
//! and the pending and priority state of the system exceptions that belongs to the system control
//! block.

use super::exceptions::{FIRST_INTERRUPT, PENDSV, SVCALL, SYSTICK};

/// Only the upper two bits of a priority exist on ARMv6-M.
const PRIORITY_BITS: u8 = 0xc0;

/// Enable, pending and priority of interrupts; pending and priority of PendSV, SysTick and SVCall.
#[derive(Clone, Debug, Default)]
pub(super) struct Nvic {
    pub enabled: u32,
    /// A rising edge on a line makes its interrupt pending, and it stays so until it is taken or
    /// cleared, even if the line falls meanwhile (B3.4.1).
    pub pending: u32,
    pub priorities: [u8; 32],
    pendsv_pending: bool,
    systick_pending: bool,
    pub svcall_priority: u8,
    pub pendsv_priority: u8,
    pub systick_priority: u8,
}

impl Nvic {
    pub fn pendsv_pending(&self) -> bool {
        self.pendsv_pending
    }

    pub fn systick_pending(&self) -> bool {
        self.systick_pending
    }

    pub fn set_pendsv_pending(&mut self, pending: bool) {
        self.pendsv_pending = pending;
    }

    pub fn set_systick_pending(&mut self, pending: bool) {
        self.systick_pending = pending;
    }

    /// Priority of an exception; lower is more urgent.
    pub fn priority(&self, exception: u32) -> i16 {
        match exception {
            1 => -3,
            2 => -2,
            3 => -1,
            SVCALL => i16::from(self.svcall_priority),
            PENDSV => i16::from(self.pendsv_priority),
            SYSTICK => i16::from(self.systick_priority),
            interrupt => i16::from(self.priorities[(interrupt - FIRST_INTERRUPT) as usize & 31]),
        }
    }

    /// The pending and enabled exception with the most urgent priority; of equals the lowest number
    /// (B1.5.4).
    pub fn most_urgent(&self) -> Option<u32> {
        let mut interrupts = self.pending & self.enabled;
        let mut best: Option<u32> = None;
        let mut offer = |exception: u32| {
            if best.is_none_or(|b| self.priority(exception) < self.priority(b)) {
                best = Some(exception);
            }
        };
        if self.pendsv_pending {
            offer(PENDSV);
        }
        if self.systick_pending {
            offer(SYSTICK);
        }
        while interrupts != 0 {
            offer(FIRST_INTERRUPT + interrupts.trailing_zeros());
            interrupts &= interrupts - 1;
        }
        best
    }

    /// The exception is being entered.
    pub fn clear_pending(&mut self, exception: u32) {
        match exception {
            PENDSV => self.pendsv_pending = false,
            SYSTICK => self.systick_pending = false,
            FIRST_INTERRUPT.. => self.pending &= !(1 << (exception - FIRST_INTERRUPT)),
            _ => {}
        }
    }

    /// NVIC_IPR0 to 7.
    pub fn read_priorities(&self, register: usize) -> u32 {
        (0..4).map(|byte| u32::from(self.priorities[4 * register + byte]) << (8 * byte)).sum()
    }

    pub fn write_priorities(&mut self, register: usize, value: u32) {
        for (byte, priority) in value.to_le_bytes().into_iter().enumerate() {
            self.priorities[4 * register + byte] = priority & PRIORITY_BITS;
        }
    }

    /// SHPR2: SVCall.
    pub fn write_shpr2(&mut self, value: u32) {
        self.svcall_priority = (value >> 24) as u8 & PRIORITY_BITS;
    }

    pub fn read_shpr2(&self) -> u32 {
        u32::from(self.svcall_priority) << 24
    }

    /// SHPR3: PendSV and SysTick.
    pub fn write_shpr3(&mut self, value: u32) {
        self.pendsv_priority = (value >> 16) as u8 & PRIORITY_BITS;
        self.systick_priority = (value >> 24) as u8 & PRIORITY_BITS;
    }

    pub fn read_shpr3(&self) -> u32 {
        u32::from(self.pendsv_priority) << 16 | u32::from(self.systick_priority) << 24
    }
}
