//! The firmware's ELF, built when a test first asks for it.

use elf::ElfBytes;
use elf::endian::AnyEndian;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::{env, fs};

/// What `rustup target add` must have been told; `rust-toolchain.toml` names it, so rustup normally
/// has.
const TARGET: &str = "thumbv6m-none-eabi";
const PACKAGE: &str = "pneudrive-firmware";
/// Where the program's vectors are when it runs.
const VECTOR_TABLE: u32 = 0x2000_0000;

/// The firmware for the RP2040, as it is flashed.
///
/// Built by cargo where `cargo fw-build` builds it: who has built it waits for nothing. The first
/// time takes about a minute; tests that run at the same time wait for each other.
///
/// # Panics
/// If it does not build; the compiler's words are on standard error.
pub fn elf() -> &'static [u8] {
    static ELF: OnceLock<Vec<u8>> = OnceLock::new();
    ELF.get_or_init(|| {
        let path = build();
        fs::read(&path).unwrap_or_else(|error| panic!("cannot read {}: {error}", path.display()))
    })
}

/// Where [`elf()`] is, for programs that are given its path.
///
/// # Panics
/// As [`elf()`].
pub fn elf_path() -> PathBuf {
    elf();
    artefact()
}

fn build() -> PathBuf {
    cargo("build", &[]);
    artefact()
}

/// The tests that a board runs behind a debug probe (`firmware/tests/on_target.rs`), as they are
/// flashed.
///
/// # Panics
/// As [`elf()`].
pub fn on_target_tests() -> Vec<u8> {
    let messages = cargo("test", &["--test", "on_target", "--no-run", "--message-format", "json"]);
    let executable = messages.lines().find_map(|line| {
        let message: serde_json::Value = serde_json::from_str(line).ok()?;
        let ours = message["target"]["name"] == "on_target";
        message["executable"].as_str().filter(|_| ours).map(PathBuf::from)
    });
    let path = executable.unwrap_or_else(|| panic!("cargo names no executable: {messages}"));
    fs::read(&path).unwrap_or_else(|error| panic!("cannot read {}: {error}", path.display()))
}

/// What cargo does with the firmware, for the chip; gives what it prints.
fn cargo(command: &str, arguments: &[&str]) -> String {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args([command, "--quiet", "--release", "--package", PACKAGE, "--target", TARGET])
        .args(arguments)
        .arg("--target-dir")
        .arg(target_folder())
        .current_dir(workspace())
        // Flags meant for the host (coverage, sanitizers) do not suit the chip.
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .stderr(Stdio::inherit())
        .output();
    match output {
        Ok(output) if output.status.success() => String::from_utf8_lossy(&output.stdout).into_owned(),
        Ok(output) => {
            panic!("building {PACKAGE} for {TARGET} failed ({}); is the target installed?", output.status)
        }
        Err(error) => panic!("cannot run cargo to build {PACKAGE}: {error}"),
    }
}

fn artefact() -> PathBuf {
    target_folder().join(TARGET).join("release").join(PACKAGE)
}

fn target_folder() -> PathBuf {
    workspace().join(env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The firmware with one instruction of a function replaced: what a fault in the program would do.
///
/// `function` is a part of its mangled name; the first halfword of the function becomes
/// `instruction`.
///
/// # Panics
/// If there is not exactly one such function.
pub fn with_broken(function: &str, instruction: u16) -> Vec<u8> {
    let mut elf = elf().to_vec();
    let offset = file_offset_of_address(&elf, address_of_function(function))
        .unwrap_or_else(|| panic!("{function} is in no segment"));
    elf[offset..offset + 2].copy_from_slice(&instruction.to_le_bytes());
    elf
}

/// The firmware with another function as handler of an interrupt: what its handler would do if it
/// called this.
///
/// `function` is a part of its mangled name.
///
/// # Panics
/// If there is not exactly one such function.
pub fn with_handler(irq: usize, function: &str) -> Vec<u8> {
    let mut elf = elf().to_vec();
    let handler = address_of_function(function) | 1;
    let table = file_offset_of_address(&elf, VECTOR_TABLE).unwrap_or_else(|| panic!("no vector table"));
    let vector = table + 4 * (16 + irq);
    elf[vector..vector + 4].copy_from_slice(&handler.to_le_bytes());
    elf
}

/// The functions of the firmware: mangled names and the addresses at which they run.
///
/// # Panics
/// If the firmware has no symbols.
pub fn functions() -> Vec<(String, u32)> {
    // Bit 0 says that it is Thumb code.
    symbols(elf(), elf::abi::STT_FUNC).into_iter().map(|(name, address)| (name, address & !1)).collect()
}

/// Where the only variable with this name is.
///
/// # Panics
/// If there is not exactly one.
pub fn address_of_variable(name: &str) -> u32 {
    let mut found = symbols(elf(), elf::abi::STT_OBJECT);
    found.retain(|(symbol, _)| symbol == name);
    let [(_, address)] = found[..] else { panic!("{} variables are called {name}", found.len()) };
    address
}

fn symbols(bytes: &[u8], kind: u8) -> Vec<(String, u32)> {
    let file = ElfBytes::<AnyEndian>::minimal_parse(bytes).ok();
    let Some(Some((symbols, names))) = file.and_then(|file| file.symbol_table().ok()) else {
        panic!("the firmware has no symbols")
    };
    let name =
        |symbol: &elf::symbol::Symbol| names.get(symbol.st_name as usize).unwrap_or_default().to_owned();
    let of_kind = symbols.iter().filter(|symbol| symbol.st_symtype() == kind);
    of_kind.map(|symbol| (name(&symbol), symbol.st_value as u32)).collect()
}

/// Where the only function is that has this name, or this in its mangled name.
///
/// # Panics
/// If there is not exactly one.
pub fn address_of_function(part_of_name: &str) -> u32 {
    let all = functions();
    let exactly: Vec<_> = all.iter().filter(|(name, _)| name == part_of_name).collect();
    let found = if exactly.is_empty() {
        all.iter().filter(|(name, _)| name.contains(part_of_name)).collect()
    } else {
        exactly
    };
    let [&(_, address)] = found[..] else { panic!("{} functions are called {part_of_name}", found.len()) };
    address
}

/// Where in the file the byte is that the program finds at this address.
pub fn file_offset_of_address(elf: &[u8], address: u32) -> Option<usize> {
    let segments = ElfBytes::<AnyEndian>::minimal_parse(elf).ok()?.segments()?;
    let address = u64::from(address);
    let segment = segments.iter().find(|s| (s.p_vaddr..s.p_vaddr + s.p_filesz).contains(&address))?;
    Some((segment.p_offset + address - segment.p_vaddr) as usize)
}
