//! A host that brings one emulated chip a new program, request by request.

use crate::chip_bench::{BOOT, ChipBench};
use crate::firmware;
use crate::session_host::{SessionHost, words_of};
use pneudrive_chip::Ticks;
use pneudrive_protocol::pages::{
    Entry, PageEntry, Update, UpdateAnswer, UpdateEntry, UpdateReply, UpdateState, number_in,
};
use pneudrive_protocol::program::{Program, crc};

const MS: Ticks = Ticks::from_millis(1);
/// From a commit until the program on trial answers: flash, and two starts.
pub const TRIAL_BOOT: Ticks = Ticks::from_millis(1_300);
/// Where the program is in flash, and how many bytes further the other place.
const PLACE: u32 = 0x1000_4000;
const PLACE_BYTES: usize = 128 * 1024;

/// The program of the firmware's ELF file, or of a broken one.
///
/// # Panics
/// If the file has none.
pub fn program_of(elf: &[u8]) -> Vec<u8> {
    let start = firmware::file_offset_of_address(elf, 0x2000_0000).unwrap_or_else(|| panic!("no program"));
    let program = Program::parse(&elf[start..]).unwrap_or_else(|error| panic!("{error}"));
    elf[start..start + program.length].to_vec()
}

/// The same program with another version number, so that it can be told from the one that is
/// flashed.
///
/// # Panics
/// If the firmware has none.
pub fn next_version() -> Vec<u8> {
    let mut program = program_of(firmware::elf());
    program[204..208].copy_from_slice(&(9_u32 << 20).to_le_bytes());
    program
}

/// What an update sends: the program and its CRC, in pieces.
pub fn pieces(program: &[u8]) -> Vec<[u8; 3]> {
    let bytes = [program, &crc(program).to_le_bytes()].concat();
    bytes.chunks(3).map(|piece| std::array::from_fn(|n| piece.get(n).copied().unwrap_or(0))).collect()
}

/// A chip, and a host at its bus.
#[derive(Clone)]
pub struct UpdateBench {
    /// The chip.
    pub bench: ChipBench,
    /// The host.
    pub host: SessionHost,
    /// The longest time from a request to its answer.
    pub slowest: Ticks,
}

impl UpdateBench {
    /// Without a session.
    pub fn new(bench: ChipBench) -> Self {
        Self { bench, host: SessionHost::new(0), slowest: Ticks::ZERO }
    }

    /// In a session, with 0 kPa commanded.
    ///
    /// # Panics
    /// When the board gives none.
    pub fn in_session(bench: ChipBench) -> Self {
        let mut host = Self::new(bench);
        let offer = host.ask(PageEntry::Session(3));
        host.host.begin(offer);
        host.command();
        host
    }

    /// Forgets the session, as a host that comes anew.
    pub fn forget(&mut self) {
        self.host = SessionHost::new(0);
    }

    fn note(&mut self, delay: Ticks) {
        self.slowest = self.slowest.max(delay);
    }

    /// Commands 0 kPa.
    ///
    /// # Panics
    /// When that is not answered.
    pub fn command(&mut self) {
        let bytes = self.host.command([102; 4]);
        let answer =
            self.bench.exchange_bytes(&bytes).unwrap_or_else(|| panic!("a command was not answered"));
        self.note(answer.delay);
    }

    /// Asks for an entry; `None` if nothing comes.
    pub fn try_ask(&mut self, entry: PageEntry) -> Option<Entry> {
        let request = self.host.request(entry);
        let answer = self.bench.exchange_bytes(&request.encode())?;
        self.note(answer.delay);
        Some(words_of(request, &answer))
    }

    /// The same, which must be answered.
    ///
    /// # Panics
    /// When it is not.
    pub fn ask(&mut self, entry: PageEntry) -> Entry {
        self.try_ask(entry).unwrap_or_else(|| panic!("{entry:?} was not answered"))
    }

    /// An update's request.
    ///
    /// # Panics
    /// When it is not answered.
    pub fn update(&mut self, update: Update) -> UpdateReply {
        let words = self.ask(PageEntry::Update(update));
        UpdateAnswer::from_entry(words).unwrap_or_else(|| panic!("{words:?}")).reply
    }

    /// The state of updates.
    ///
    /// # Panics
    /// When the board does not answer.
    pub fn state(&mut self) -> UpdateState {
        let words = self.ask(PageEntry::Program(UpdateEntry::State));
        UpdateState::from_entry(words).unwrap_or_else(|| panic!("{words:?}"))
    }

    /// CRC-32 of the running program, 0 if it is as flashed.
    ///
    /// # Panics
    /// When the board does not answer.
    pub fn running_crc(&mut self) -> u32 {
        number_in(self.ask(PageEntry::Program(UpdateEntry::RunningCrc)))
            .unwrap_or_else(|| panic!("no number"))
    }

    /// Sends a program as far as its commit, which it leaves out.
    ///
    /// # Panics
    /// When the board refuses something.
    pub fn send(&mut self, program: &[u8]) {
        assert_eq!(self.update(Update::Begin), UpdateReply::Taken);
        for (n, piece) in pieces(program).into_iter().enumerate() {
            if n % 100 == 0 {
                self.command();
            }
            assert_eq!(self.update(Update::Bytes(piece)), UpdateReply::Taken, "piece {n}");
        }
    }

    /// Puts another program, as long as the one that was sent, where the board has collected that:
    /// what would have been sent in its place.
    ///
    /// # Panics
    /// If the firmware keeps it elsewhere.
    pub fn replace(&mut self, program: &[u8], crc: u32) {
        let inbox = firmware::address_of_variable("UPDATE_INBOX");
        assert!(self.bench.chip.write_memory(inbox, &[program, &crc.to_le_bytes()].concat()));
    }

    /// Commits; the board is on trial afterwards, or back.
    ///
    /// # Panics
    /// When the board refuses it.
    pub fn commit(&mut self) {
        self.command();
        assert_eq!(self.update(Update::Commit), UpdateReply::Taken);
        self.bench.run(TRIAL_BOOT);
        self.forget();
    }

    /// Confirms a trial; the board has restarted afterwards.
    ///
    /// # Panics
    /// When the board refuses it.
    pub fn confirm(&mut self) {
        let offer = self.ask(PageEntry::Session(4));
        self.host.begin(offer);
        self.command();
        assert_eq!(self.update(Update::Confirm), UpdateReply::Taken);
        self.bench.run(MS * 300 + BOOT);
        self.forget();
    }

    /// Switches the supply off and on, and waits for the start.
    pub fn power_cycle(&mut self) {
        self.bench.chip.power_cycle();
        self.bench.run(BOOT);
        self.forget();
    }

    /// What a place in flash holds, 0 or 1.
    pub fn place(&self, place: usize, length: usize) -> Vec<u8> {
        let start = PLACE + (place * PLACE_BYTES) as u32;
        (start..start + length as u32).filter_map(|address| self.bench.chip.read_memory(address)).collect()
    }
}
