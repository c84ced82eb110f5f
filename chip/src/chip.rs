//! The chip as a whole: loading, running, resets.

use crate::bus::Bus;
use crate::cortex_m0::{Activity, Core};
use crate::image::{BOOT_LOADER, ElfError, Image, VECTOR_TABLE};
use crate::report::{FlashAccesses, HardFault, Reset, ResetReason, UnmodelledAccess};
use crate::rtt;
use crate::ticks::Ticks;

/// An RP2040 with a program in its flash, running in virtual time.
///
/// ```no_run
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use pneudrive_chip::{Chip, Level, Ticks};
///
/// let mut chip = Chip::from_elf(&std::fs::read("firmware.elf")?)?;
/// chip.set_pin_input(14, Level::Low);
/// chip.run_until(Ticks::from_millis(150));
/// for sent in chip.take_transmitted(0) {
///     println!("{:02x} from {} to {}", sent.byte, sent.start, sent.end);
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Chip {
    pub(crate) core: Core,
    pub(crate) bus: Bus,
    image: Image,
    log: Vec<u8>,
    resets: Vec<Reset>,
    core_event: Ticks,
    /// Until then the processor executes nothing.
    pub(crate) stalled_until: Ticks,
}

impl Chip {
    /// Loads the segments of an ELF file by physical address and powers the chip.
    ///
    /// The boot ROM does not run: the core starts where it would hand over, in the second-stage
    /// boot loader (the first 256 bytes of flash), or, if these are blank, from the vector table at
    /// 0x1000_0100. The clocks are as the reset leaves them.
    ///
    /// # Errors
    ///
    /// [`ElfError`] if the file is no executable for this chip.
    pub fn from_elf(elf: &[u8]) -> Result<Chip, ElfError> {
        Ok(Chip::with_image(Image::from_elf(elf)?))
    }

    /// The same from the raw contents of flash, from 0x1000_0000 on; there is no log then.
    ///
    /// # Errors
    ///
    /// [`ElfError`] if there is no vector table at 0x1000_0100.
    pub fn from_flash(flash: &[u8]) -> Result<Chip, ElfError> {
        Ok(Chip::with_image(Image::from_flash(flash)?))
    }

    fn with_image(image: Image) -> Chip {
        let mut chip = Chip {
            core: Core::new(),
            bus: Bus::new(image.flash.clone()),
            image,
            log: Vec::new(),
            resets: Vec::new(),
            core_event: Ticks::NEVER,
            stalled_until: Ticks::ZERO,
        };
        chip.load_sram();
        chip.start(ResetReason::PowerOn);
        chip
    }

    fn load_sram(&mut self) {
        for (address, bytes) in &self.image.sram {
            // In range: the image was checked when it was read.
            let loaded = self.bus.load_sram(*address, bytes);
            debug_assert!(loaded.is_ok());
        }
    }

    fn start(&mut self, reason: ResetReason) {
        self.resets.push(Reset { at: self.bus.now, reason });
        self.stalled_until = Ticks::ZERO;
        self.bus.restart_flash(self.image.boot_loader.is_some());
        match &self.image.boot_loader {
            Some(code) => {
                // In range: the end of the last bank.
                let loaded = self.bus.load_sram(BOOT_LOADER, code);
                debug_assert!(loaded.is_ok());
                self.core.start_at(&mut self.bus, BOOT_LOADER, BOOT_LOADER);
            }
            None => self.core.reset(&mut self.bus, VECTOR_TABLE),
        }
    }

    /// Virtual time: 0 at the creation of the chip, never going back.
    pub fn now(&self) -> Ticks {
        self.bus.now
    }

    /// Runs until [`Chip::now`] is at least `until`. An instruction is never cut: `now` may be
    /// later by the cycles of one instruction, exception entry or read from flash. Whatever the
    /// peripherals do at or before `until` has been done.
    pub fn run_until(&mut self, until: Ticks) {
        loop {
            if self.bus.take_core_pause() {
                self.look_at_core();
            }
            let due = self.bus.next_event().min(self.core_event);
            if due <= self.bus.now {
                self.do_events();
                continue;
            }
            if self.bus.now >= until {
                return;
            }
            if self.bus.now < self.stalled_until {
                self.bus.now = due.min(until).min(self.stalled_until);
            } else if self.core.activity() == Activity::Running {
                self.core.run(&mut self.bus, until.min(self.core_event));
            } else if !(self.bus.interrupts_changed() && self.core.try_wake(&mut self.bus)) {
                self.bus.interrupts_seen();
                self.bus.now = due.min(until);
            }
        }
    }

    /// The core is to be looked at: its clock or timer changed, or somebody asks for a reset.
    fn look_at_core(&mut self) {
        if std::mem::take(&mut self.bus.clocks_changed) {
            self.core.reclock(&self.bus);
        }
        self.core_event = self.core.next_event();
        // The boot ROM waits for the flash chip.
        self.stalled_until = self.stalled_until.max(self.bus.flash_busy_until());
        if self.core.take_system_reset_request() {
            self.drain_log();
            self.start(ResetReason::SystemResetRequest);
        }
        if let Some(reason) = self.bus.take_reset_request() {
            self.drain_log();
            if self.bus.reset_by_watchdog(reason) {
                self.start(reason);
            }
        }
    }

    fn do_events(&mut self) {
        self.bus.advance();
        self.core.advance(&mut self.bus);
        self.core_event = self.core.next_event();
    }

    /// When the chip can next do something by itself: now while the core executes, else the time of
    /// the next peripheral event, or [`Ticks::NEVER`]. Until then [`Chip::run_until`] costs next to
    /// nothing and nothing observable changes, unless a pin or a wire does.
    pub fn next_event(&self) -> Ticks {
        let peripherals = self.bus.next_event().min(self.core_event);
        match self.core.activity() {
            _ if self.bus.now < self.stalled_until => peripherals.min(self.stalled_until).max(self.bus.now),
            Activity::Running => self.bus.now,
            _ if self.bus.interrupts_changed() || self.bus.core_paused() => self.bus.now,
            _ => peripherals.max(self.bus.now),
        }
    }

    /// Switches the power off and on again: registers and RAM are lost, the program starts from its
    /// reset vector. Time goes on; flash, levels on the pins and logs stay. An erase or a program
    /// that is going on ends half done.
    pub fn power_cycle(&mut self) {
        self.drain_log();
        self.bus.power_cycle();
        self.load_sram();
        self.start(ResetReason::PowerOn);
    }

    /// All resets so far, the first being the power-on.
    pub fn resets(&self) -> &[Reset] {
        &self.resets
    }

    /// HardFaults taken so far.
    pub fn hard_faults(&self) -> u64 {
        self.core.counters().hard_faults
    }

    /// The last HardFault.
    pub fn last_hard_fault(&self) -> Option<HardFault> {
        self.core.counters().last_hard_fault
    }

    /// The core has faulted in its HardFault handler and stands still until a reset.
    pub fn is_locked_up(&self) -> bool {
        self.core.activity() == Activity::LockedUp
    }

    /// The core sleeps in WFE or WFI.
    pub fn is_asleep(&self) -> bool {
        matches!(self.core.activity(), Activity::WaitingForEvent | Activity::WaitingForInterrupt)
    }

    /// Instructions executed since creation.
    pub fn instructions(&self) -> u64 {
        self.core.counters().instructions
    }

    /// Processor cycles spent executing since creation; sleeping counts none.
    pub fn cycles(&self) -> u64 {
        self.bus.cycles()
    }

    /// How often an interrupt handler has been entered, by interrupt number 0 to 31 (datasheet
    /// 2.3.2).
    pub fn interrupts_taken(&self, irq: usize) -> u64 {
        self.core.counters().exceptions[16 + irq]
    }

    /// The lowest value the stack pointer has had since creation or the last
    /// [`Chip::clear_lowest_stack_pointer`]: with the initial one, which is the first word of the
    /// vector table, the deepest the stack has been.
    pub fn lowest_stack_pointer(&self) -> u32 {
        self.core.counters().lowest_sp
    }

    /// Starts the search for the lowest stack pointer again from where it stands.
    pub fn clear_lowest_stack_pointer(&mut self) {
        let sp = self.core.register(13);
        self.core.counters_mut().lowest_sp = sp;
    }

    /// Address of the next instruction.
    pub fn program_counter(&self) -> u32 {
        self.core.pc()
    }

    /// Words that processor and DMA have read from flash, and of these the ones that the XIP cache
    /// had: CTR_ACC and CTR_HIT (datasheet 2.6.3), which the program can clear.
    pub fn flash_accesses(&self) -> FlashAccesses {
        let (total, hits) = self.bus.flash_accesses();
        FlashAccesses { total, hits }
    }

    /// When the flash chip has done, or will have done, what the program last told it to (a sector
    /// erase or page programs, through the boot ROM); zero if nothing since power-on.
    /// [`Chip::power_cycle`] before that leaves the change half done.
    pub fn flash_busy_until(&self) -> Ticks {
        self.bus.flash_busy_until()
    }

    /// Empties the XIP cache, as other code does that has run meanwhile. What is in flash is slow
    /// again the first time.
    pub fn flush_xip_cache(&mut self) {
        self.bus.flush_cache();
    }

    /// Register accesses that could not be honoured, with their number, in order of address.
    pub fn unmodelled_accesses(&self) -> impl Iterator<Item = (UnmodelledAccess, u64)> + '_ {
        self.bus.unmodelled().iter()
    }

    /// A byte of memory, as a debugger reads it. None outside flash and SRAM.
    pub fn read_memory(&self, address: u32) -> Option<u8> {
        self.bus.peek(address)
    }

    /// The bytes logged through RTT since the last call: the raw stream, for `defmt-print` if the
    /// program logs with defmt. Empty if the program has no RTT control block.
    ///
    /// The buffer on the chip is as small as the program made it (1 KiB with defmt-rtt), and a
    /// program whose buffer is full drops what it logs. Call this at least as often as it fills.
    pub fn take_rtt(&mut self) -> Vec<u8> {
        self.drain_log();
        std::mem::take(&mut self.log)
    }

    fn drain_log(&mut self) {
        if let Some(control_block) = self.image.rtt {
            // A control block the program has damaged points anywhere: then there is nothing more
            // to read.
            let _: Result<(), _> = rtt::drain(&mut self.bus, control_block, &mut self.log);
        }
    }
}
