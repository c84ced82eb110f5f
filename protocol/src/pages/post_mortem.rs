use core::fmt;

/// Why a board stopped, in words that survive a reset in memory that nobody initialises, and that
/// page 3 consists of.
///
/// A checksum tells a record from what such memory holds after power-on.
///
/// ```
/// use pneudrive_protocol::pages::{PostMortem, StopCause};
///
/// let record = PostMortem { cause: StopCause::panic("src/bus.rs", 42), at_us: 7_000 };
/// let mut words = record.to_words();
/// assert_eq!(PostMortem::from_words(&words), Some(record));
/// words[5] ^= 1;
/// assert_eq!(PostMortem::from_words(&words), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PostMortem {
    /// What happened.
    pub cause: StopCause,
    /// When, on the clock of the run that it ended, us.
    pub at_us: u64,
}

/// What made a board stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopCause {
    /// The program found that it cannot go on.
    Panic {
        /// Source file.
        file: FileName,
        /// Line in it.
        line: u32,
    },
    /// The processor could not execute an instruction.
    HardFault(FaultRegisters),
    /// Neither: the watchdog's last check. A part that had not run since the check before kept it
    /// from being fed; if both had, the check itself was not made any more.
    LastCheck {
        /// Whether the control loop had made a step.
        control_ran: bool,
        /// Whether the bus responder had run.
        bus_ran: bool,
    },
}

/// The registers that the processor stacks when it faults (ARMv6-M B1.5.6).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultRegisters {
    /// R0 to R3.
    pub r: [u32; 4],
    /// R12.
    pub r12: u32,
    /// Return address of the function that faulted.
    pub lr: u32,
    /// Address of the instruction.
    pub pc: u32,
    /// Flags, and in the lowest bits the exception that was being handled.
    pub xpsr: u32,
}

/// The end of a source file's name.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct FileName([u8; FILE_NAME]);

const FILE_NAME: usize = 4 * FILE_NAME_WORDS;
const FILE_NAME_WORDS: usize = 8;
const CONTENT: usize = 9;

const PANIC: u32 = 0x504d_0001;
const HARD_FAULT: u32 = 0x504d_0002;
const LAST_CHECK: u32 = 0x504d_0003;

impl FileName {
    /// The last 32 bytes of `name`.
    pub fn new(name: &str) -> Self {
        let mut bytes = [0; FILE_NAME];
        let skipped = name.len().saturating_sub(FILE_NAME);
        for (byte, from) in bytes.iter_mut().zip(name.bytes().skip(skipped)) {
            *byte = from;
        }
        Self(bytes)
    }

    /// The name; empty if a multi-byte character was cut.
    pub fn as_str(&self) -> &str {
        let len = self.0.iter().position(|byte| *byte == 0).unwrap_or(FILE_NAME);
        self.0.get(..len).and_then(|bytes| core::str::from_utf8(bytes).ok()).unwrap_or("")
    }
}

impl fmt::Debug for FileName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.as_str())
    }
}

impl StopCause {
    /// A panic at this place.
    pub fn panic(file: &str, line: u32) -> Self {
        Self::Panic { file: FileName::new(file), line }
    }

    fn to_words(self) -> (u32, [u32; CONTENT]) {
        match self {
            Self::Panic { file, line } => {
                let mut words = [line; CONTENT];
                for (word, bytes) in words.iter_mut().skip(1).zip(file.0.as_chunks::<4>().0) {
                    *word = u32::from_le_bytes(*bytes);
                }
                (PANIC, words)
            }
            Self::HardFault(FaultRegisters { r: [r0, r1, r2, r3], r12, lr, pc, xpsr }) => {
                (HARD_FAULT, [r0, r1, r2, r3, r12, lr, pc, xpsr, 0])
            }
            Self::LastCheck { control_ran, bus_ran } => {
                (LAST_CHECK, [control_ran.into(), bus_ran.into(), 0, 0, 0, 0, 0, 0, 0])
            }
        }
    }

    fn from_words(kind: u32, words: [u32; CONTENT]) -> Option<Self> {
        let [r0, r1, r2, r3, r12, lr, pc, xpsr, _] = words;
        Some(match kind {
            PANIC => {
                let [line, name @ ..] = words;
                let mut bytes = [0; FILE_NAME];
                for (four, word) in bytes.as_chunks_mut::<4>().0.iter_mut().zip(name) {
                    *four = word.to_le_bytes();
                }
                Self::Panic { file: FileName(bytes), line }
            }
            HARD_FAULT => Self::HardFault(FaultRegisters { r: [r0, r1, r2, r3], r12, lr, pc, xpsr }),
            LAST_CHECK => Self::LastCheck { control_ran: r0 != 0, bus_ran: r1 != 0 },
            _ => return None,
        })
    }
}

impl PostMortem {
    /// Words of a record.
    pub const WORDS: usize = CONTENT + 4;

    /// The record: kind, time, content, checksum.
    pub fn to_words(&self) -> [u32; Self::WORDS] {
        let (kind, content) = self.cause.to_words();
        let mut words = [0; Self::WORDS];
        words[0] = kind;
        words[1] = self.at_us as u32;
        words[2] = (self.at_us >> 32) as u32;
        words[3..3 + CONTENT].copy_from_slice(&content);
        words[Self::WORDS - 1] = checksum(&words[..Self::WORDS - 1]);
        words
    }

    /// The record in these words, if there is one.
    pub fn from_words(words: &[u32; Self::WORDS]) -> Option<Self> {
        let [kind, low, high, content @ .., found] = words;
        if *found != checksum(&words[..Self::WORDS - 1]) {
            return None;
        }
        let at_us = u64::from(*high) << 32 | u64::from(*low);
        StopCause::from_words(*kind, *content).map(|cause| Self { cause, at_us })
    }
}

impl fmt::Display for PostMortem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.cause {
            StopCause::Panic { file, line } => write!(f, "panic at {}:{line}", file.as_str())?,
            StopCause::HardFault(FaultRegisters { r, r12, lr, pc, xpsr }) => write!(
                f,
                "HardFault at pc 0x{pc:08x}, lr 0x{lr:08x}, xpsr 0x{xpsr:08x}, r0 to r3 {:08x} {:08x} {:08x} {:08x}, r12 {r12:08x}",
                r[0], r[1], r[2], r[3]
            )?,
            StopCause::LastCheck { control_ran, bus_ran } => {
                let ran = |ran: &bool| if *ran { "had run" } else { "had not run" };
                write!(
                    f,
                    "watchdog not fed; at the last check the control loop {} and the bus {}",
                    ran(control_ran),
                    ran(bus_ran)
                )?;
            }
        }
        write!(f, ", {}.{:06} s after start", self.at_us / 1_000_000, self.at_us % 1_000_000)
    }
}

/// FNV-1a over the words, inverted so that zeros are no record.
fn checksum(words: &[u32]) -> u32 {
    !words.iter().fold(0x811c_9dc5, |hash: u32, word| (hash ^ word).wrapping_mul(0x0100_0193))
}

#[cfg(feature = "defmt")]
impl defmt::Format for PostMortem {
    fn format(&self, f: defmt::Formatter<'_>) {
        let us = self.at_us;
        match self.cause {
            StopCause::Panic { file, line } => {
                defmt::write!(f, "panic at {=str}:{=u32}, {=u64} us after start", file.as_str(), line, us);
            }
            StopCause::HardFault(FaultRegisters { r: [r0, r1, r2, r3], r12, lr, pc, xpsr }) => defmt::write!(
                f,
                "HardFault at pc {=u32:x} lr {=u32:x} xpsr {=u32:x} r0 {=u32:x} r1 {=u32:x} r2 {=u32:x} r3 {=u32:x} r12 {=u32:x}, {=u64} us after start",
                pc,
                lr,
                xpsr,
                r0,
                r1,
                r2,
                r3,
                r12,
                us
            ),
            StopCause::LastCheck { control_ran, bus_ran } => defmt::write!(
                f,
                "watchdog not fed; at the last check control loop ran {=bool}, bus ran {=bool}, {=u64} us after start",
                control_ran,
                bus_ran,
                us
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn records() -> [PostMortem; 4] {
        let registers = FaultRegisters { r: [1, 2, 3, 4], r12: 5, lr: 6, pc: 7, xpsr: 8 };
        [
            StopCause::panic("firmware/src/a_rather_long/name_of_a/module.rs", 4_000_000_000),
            StopCause::HardFault(registers),
            StopCause::LastCheck { control_ran: true, bus_ran: false },
            StopCause::LastCheck { control_ran: false, bus_ran: true },
        ]
        .map(|cause| PostMortem { cause, at_us: 0x1_2345_6789_abcd })
    }

    #[test]
    fn records_come_back_as_they_were() {
        for record in records() {
            assert_eq!(PostMortem::from_words(&record.to_words()), Some(record));
        }
    }

    #[test]
    fn any_flipped_bit_is_noticed() {
        for record in records() {
            for bit in 0..32 * PostMortem::WORDS {
                let mut words = record.to_words();
                words[bit / 32] ^= 1 << (bit % 32);
                assert_eq!(PostMortem::from_words(&words), None, "bit {bit} of {record:?}");
            }
        }
    }

    #[test]
    fn memory_without_a_record_is_none() {
        for word in [0, u32::MAX, 0xa5a5_a5a5] {
            assert_eq!(PostMortem::from_words(&[word; PostMortem::WORDS]), None);
        }
    }

    #[test]
    fn a_long_name_keeps_its_end() {
        assert_eq!(FileName::new("src/main.rs").as_str(), "src/main.rs");
        assert_eq!(FileName::new("firmware/src/a_rather_long/name_of_a/module.rs").as_str().len(), 32);
        assert!(
            FileName::new("firmware/src/a_rather_long/name_of_a/module.rs").as_str().ends_with("module.rs")
        );
        assert_eq!(
            FileName::new("\u{e4}-234567890123456789012345678901").as_str(),
            "",
            "cut inside a character"
        );
    }
}
