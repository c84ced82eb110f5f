//! The bodies of `firmware/tests/on_target.rs`, which a board runs behind a debug probe, on the
//! emulated chip.
//!
//! Here stands what the probe's program does then: it finds the tests in the file, starts the chip
//! once for each, and tells it by semihosting which one to run.

use elf::ElfBytes;
use elf::endian::LittleEndian;
use pneudrive_chip::{Chip, SEMIHOSTING, Ticks};
use system_tests::firmware;

/// Operations of semihosting (ARM IHI 0105, chapter 6).
const SYS_GET_CMDLINE: u32 = 0x15;
const SYS_EXIT: u32 = 0x18;
const SYS_EXIT_EXTENDED: u32 = 0x20;
/// The program has ended as it should.
const APPLICATION_EXIT: u32 = 0x2_0026;

const STEP: Ticks = Ticks::from_micros(100);
const TIMEOUT: Ticks = Ticks::from_millis(5_000);

struct Test {
    name: String,
    entry: u32,
}

/// What embedded-test puts into the file: for each test a symbol whose name is JSON, at the address
/// of its function's.
fn tests(file: &[u8]) -> Vec<Test> {
    let parsed = ElfBytes::<LittleEndian>::minimal_parse(file);
    let elf = parsed.unwrap_or_else(|error| panic!("not an ELF file: {error}"));
    let section = elf.section_header_by_name(".embedded_test").ok().flatten();
    let section = section.unwrap_or_else(|| panic!("there are no tests in the file"));
    let data = elf.section_data(&section).map_or(&[][..], |(data, _)| data);
    let Ok(Some((symbols, names))) = elf.symbol_table() else { panic!("the file has no symbols") };
    let mut tests = Vec::new();
    for symbol in symbols.iter() {
        let name = names.get(symbol.st_name as usize).unwrap_or_default();
        let Ok(json) = serde_json::from_str::<serde_json::Value>(name) else { continue };
        let Some(name) = json["name"].as_str() else { continue };
        let at = (symbol.st_value - section.sh_addr) as usize;
        let Some(entry) = data.get(at..).and_then(|data| data.first_chunk()) else { continue };
        assert_eq!((&json["ignored"], &json["should_panic"]), (&false.into(), &false.into()), "{name}");
        tests.push(Test { name: name.to_owned(), entry: u32::from_le_bytes(*entry) });
    }
    tests
}

/// Runs one test; an error says what came instead of its end.
fn run(file: &[u8], test: &Test) -> Result<(), String> {
    let mut chip = Chip::from_elf(file).map_err(|error| error.to_string())?;
    chip.attach_debugger();
    while chip.now() < TIMEOUT {
        chip.run_until(chip.now() + STEP);
        let Some(breakpoint) = chip.breakpoint() else { continue };
        let (operation, argument) = (chip.register(0), chip.register(1));
        match (breakpoint, operation) {
            (SEMIHOSTING, SYS_GET_CMDLINE) => {
                answer_command_line(&mut chip, argument, &format!("run_addr {}", test.entry));
            }
            (SEMIHOSTING, SYS_EXIT) if argument == APPLICATION_EXIT => return verdict(&chip),
            (SEMIHOSTING, SYS_EXIT_EXTENDED)
                if (word(&chip, argument), word(&chip, argument + 4)) == (APPLICATION_EXIT, 0) =>
            {
                return verdict(&chip);
            }
            (SEMIHOSTING, SYS_EXIT | SYS_EXIT_EXTENDED) => return Err("an assertion failed".into()),
            other => return Err(format!("breakpoint and operation {other:x?} are not known")),
        }
        chip.resume();
    }
    Err(format!("no end; at {:#010x}, {:?}", chip.program_counter(), chip.last_hard_fault()))
}

fn verdict(chip: &Chip) -> Result<(), String> {
    let unmodelled: Vec<_> = chip.unmodelled_accesses().map(|(access, _)| access.to_string()).collect();
    if unmodelled.is_empty() { Ok(()) } else { Err(format!("not emulated: {}", unmodelled.join(", "))) }
}

/// The argument points to an address for the text and its size.
fn answer_command_line(chip: &mut Chip, argument: u32, text: &str) {
    let (buffer, size) = (word(chip, argument), word(chip, argument + 4));
    assert!(size as usize > text.len(), "{size} bytes for the command line");
    let zero_terminated: Vec<u8> = text.bytes().chain([0]).collect();
    assert!(chip.write_memory(buffer, &zero_terminated));
    assert!(chip.write_memory(argument + 4, &(text.len() as u32).to_le_bytes()));
    chip.set_register(0, 0);
}

fn word(chip: &Chip, address: u32) -> u32 {
    u32::from_le_bytes(std::array::from_fn(|n| chip.read_memory(address + n as u32).unwrap_or(0)))
}

#[test]
fn the_tests_for_a_board_pass_on_the_emulated_chip() {
    let file = firmware::on_target_tests();
    let tests = tests(&file);
    assert!(tests.len() >= 7, "{} tests were found", tests.len());
    let mut failed = Vec::new();
    for test in &tests {
        let result = run(&file, test);
        println!("{}: {result:?}", test.name);
        failed.extend(result.err().map(|error| format!("{}: {error}", test.name)));
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
