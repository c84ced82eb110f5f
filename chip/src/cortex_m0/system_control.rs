//! The registers of the system control space at 0xE000E000 (B3.2 to B3.4).

use super::Core;
use super::exceptions::FIRST_INTERRUPT;
use crate::bus::Bus;
use crate::report::{Access, Concern, Fault};

const ACTLR: u32 = 0x008;
const SYST_CSR: u32 = 0x010;
const SYST_RVR: u32 = 0x014;
const SYST_CVR: u32 = 0x018;
const SYST_CALIB: u32 = 0x01c;
const NVIC_ISER: u32 = 0x100;
const NVIC_ICER: u32 = 0x180;
const NVIC_ISPR: u32 = 0x200;
const NVIC_ICPR: u32 = 0x280;
const NVIC_IPR0: u32 = 0x400;
const NVIC_IPR7: u32 = 0x41c;
const CPUID: u32 = 0xd00;
const ICSR: u32 = 0xd04;
const VTOR: u32 = 0xd08;
const AIRCR: u32 = 0xd0c;
const SCR: u32 = 0xd10;
const CCR: u32 = 0xd14;
const SHPR2: u32 = 0xd1c;
const SHPR3: u32 = 0xd20;
const DHCSR: u32 = 0xdf0;

/// CPUID of a Cortex-M0+ r0p1.
const CORTEX_M0_PLUS: u32 = 0x410c_c601;
/// CCR on ARMv6-M: STKALIGN and UNALIGN_TRP, both fixed.
const CCR_FIXED: u32 = 0x208;
const ICSR_PENDSVSET: u32 = 1 << 28;
const ICSR_PENDSVCLR: u32 = 1 << 27;
const ICSR_PENDSTSET: u32 = 1 << 26;
const ICSR_PENDSTCLR: u32 = 1 << 25;
const ICSR_ISRPENDING: u32 = 1 << 22;
const AIRCR_KEY: u32 = 0x05fa;
const AIRCR_SYSRESETREQ: u32 = 1 << 2;
const SCR_SLEEPONEXIT: u32 = 1 << 1;
const SCR_SLEEPDEEP: u32 = 1 << 2;
const SCR_SEVONPEND: u32 = 1 << 4;

/// Offset in the system control space.
fn offset(address: u32) -> Result<u32, Fault> {
    match address {
        _ if address & 3 != 0 => Err(Fault::Unaligned(address)),
        0xe000_e000..=0xe000_efff => Ok(address & 0xfff),
        _ => Err(Fault::Bus(address)),
    }
}

impl Core {
    pub(super) fn read_system_control(&mut self, bus: &mut Bus, address: u32) -> Result<u32, Fault> {
        bus.catch_up();
        let now = bus.now;
        // What the lines did since the last look must show in ISPR and ICSR.
        self.latch_interrupts(bus);
        Ok(match offset(address)? {
            ACTLR => 0,
            SYST_CSR => self.systick.read_control(now),
            SYST_RVR => self.systick.read_reload(),
            SYST_CVR => self.systick.read_current(now),
            // NOREF clear, SKEW clear, no 10 ms figure.
            SYST_CALIB => 0,
            NVIC_ISER | NVIC_ICER => self.nvic.enabled,
            NVIC_ISPR | NVIC_ICPR => self.nvic.pending,
            ipr @ NVIC_IPR0..=NVIC_IPR7 => self.nvic.read_priorities(((ipr - NVIC_IPR0) / 4) as usize),
            CPUID => CORTEX_M0_PLUS,
            ICSR => self.read_icsr(),
            VTOR => self.vector_table,
            AIRCR => 0xfa05_0000,
            SCR => u32::from(self.send_event_on_pending) << 4,
            CCR => CCR_FIXED,
            SHPR2 => self.nvic.read_shpr2(),
            SHPR3 => self.nvic.read_shpr3(),
            // No debugger is attached.
            DHCSR => 0,
            _ => {
                bus.note_unmodelled(address, Access::Read, Concern::NotModelled);
                0
            }
        })
    }

    pub(super) fn write_system_control(
        &mut self,
        bus: &mut Bus,
        address: u32,
        value: u32,
    ) -> Result<(), Fault> {
        bus.catch_up();
        self.latch_interrupts(bus);
        match offset(address)? {
            SYST_CSR => self.systick.write_control(bus, value),
            SYST_RVR => self.systick.write_reload(bus, value),
            SYST_CVR => self.systick.clear_current(bus),
            NVIC_ISER => self.nvic.enabled |= value,
            NVIC_ICER => self.nvic.enabled &= !value,
            NVIC_ISPR => self.make_pending(value),
            NVIC_ICPR => self.clear_pending(bus, value),
            ipr @ NVIC_IPR0..=NVIC_IPR7 => {
                self.nvic.write_priorities(((ipr - NVIC_IPR0) / 4) as usize, value);
            }
            ICSR => self.write_icsr(value),
            VTOR => self.vector_table = value & !0xff,
            AIRCR => {
                self.system_reset_requested |= value >> 16 == AIRCR_KEY && value & AIRCR_SYSRESETREQ != 0;
            }
            SCR => {
                self.send_event_on_pending = value & SCR_SEVONPEND != 0;
                // SLEEPDEEP would only lower the power of a sleep; SLEEPONEXIT would change what
                // runs.
                if value & !(SCR_SEVONPEND | SCR_SLEEPDEEP) & SCR_SLEEPONEXIT != 0 {
                    bus.note_unmodelled(address, Access::Write, Concern::ValueNotModelled);
                }
            }
            SHPR2 => self.nvic.write_shpr2(value),
            SHPR3 => self.nvic.write_shpr3(value),
            _ => bus.note_unmodelled(address, Access::Write, Concern::NotModelled),
        }
        bus.notice_interrupts();
        bus.pause_core();
        Ok(())
    }

    /// NVIC_ICPR: an interrupt whose line is high and which is not being handled is pending again
    /// at once.
    fn clear_pending(&mut self, bus: &Bus, mask: u32) {
        let handled = match self.ipsr.checked_sub(FIRST_INTERRUPT) {
            Some(line) => 1 << line,
            None => 0,
        };
        self.nvic.pending &= !mask;
        self.nvic.pending |= mask & bus.interrupt_lines() & !handled;
    }

    fn read_icsr(&self) -> u32 {
        let flag = |set: bool, bit: u32| if set { bit } else { 0 };
        let pending = self.nvic.most_urgent().unwrap_or(0);
        flag(self.nvic.pendsv_pending(), ICSR_PENDSVSET)
            | flag(self.nvic.systick_pending(), ICSR_PENDSTSET)
            | flag(self.nvic.pending & self.nvic.enabled != 0, ICSR_ISRPENDING)
            | pending << 12
            | self.ipsr
    }

    fn write_icsr(&mut self, value: u32) {
        if value & ICSR_PENDSVSET != 0 {
            self.nvic.set_pendsv_pending(true);
        }
        if value & ICSR_PENDSVCLR != 0 {
            self.nvic.set_pendsv_pending(false);
        }
        if value & ICSR_PENDSTSET != 0 {
            self.nvic.set_systick_pending(true);
        }
        if value & ICSR_PENDSTCLR != 0 {
            self.nvic.set_systick_pending(false);
        }
    }
}
