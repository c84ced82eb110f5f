//! What a test may want to know about a run: resets, faults, registers nobody models.

use std::collections::BTreeMap;
use std::fmt;

use crate::Ticks;

/// Why the processor started from its reset vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResetReason {
    /// Power came up (or [`crate::Chip::power_cycle`] was called).
    PowerOn,
    /// The watchdog counted down to zero (WATCHDOG REASON.TIMER).
    WatchdogTimer,
    /// The program set WATCHDOG CTRL.TRIGGER (REASON.FORCE).
    WatchdogForce,
    /// The program set AIRCR.SYSRESETREQ.
    SystemResetRequest,
}

/// One reset and when it happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reset {
    /// When.
    pub at: Ticks,
    /// Why.
    pub reason: ResetReason,
}

/// What the processor objected to. On ARMv6-M every one of these is a HardFault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// No such instruction; also `UDF`, with which panicking firmware ends.
    UndefinedInstruction,
    /// `BKPT` without a debugger.
    Breakpoint,
    /// `SVC` where the priority forbids it.
    SupervisorCall,
    /// A branch or exception return to an address without the Thumb bit, or a malformed exception
    /// return value.
    InvalidState,
    /// An address that is not a multiple of the access size.
    Unaligned(u32),
    /// Nothing answers at this address.
    Bus(u32),
}

/// One HardFault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HardFault {
    /// When.
    pub at: Ticks,
    /// Address of the instruction.
    pub pc: u32,
    /// What it did.
    pub fault: Fault,
}

impl fmt::Display for HardFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "HardFault at {} in {:#010x}: {:x?}", self.at, self.pc, self.fault)
    }
}

/// How often flash has been read, and how often the XIP cache had what was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FlashAccesses {
    /// Words read, whether the cache had them or not.
    pub total: u32,
    /// Those it had.
    pub hits: u32,
}

/// Read or write.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Access {
    /// A load.
    Read,
    /// A store.
    Write,
}

/// Why an access to a register is reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Concern {
    /// The register (or the whole peripheral) is not modelled: reads gave zero, writes went
    /// nowhere.
    NotModelled,
    /// The register is modelled but the value written asks for something that is not.
    ValueNotModelled,
    /// The peripheral was held in reset by RESETS.
    HeldInReset,
}

/// An access the emulation could not honour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct UnmodelledAccess {
    /// Address of the register, without the atomic alias bits.
    pub address: u32,
    /// Read or write.
    pub access: Access,
    /// Why it is reported.
    pub concern: Concern,
}

impl fmt::Display for UnmodelledAccess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} of {:#010x}: {:?}", self.access, self.address, self.concern)
    }
}

/// Every kind of unmodelled access with its count.
#[derive(Clone, Debug, Default)]
pub(crate) struct UnmodelledLog(BTreeMap<UnmodelledAccess, u64>);

impl UnmodelledLog {
    pub fn note(&mut self, address: u32, access: Access, concern: Concern) {
        *self.0.entry(UnmodelledAccess { address, access, concern }).or_default() += 1;
    }

    pub fn iter(&self) -> impl Iterator<Item = (UnmodelledAccess, u64)> + '_ {
        self.0.iter().map(|(access, count)| (*access, *count))
    }
}
