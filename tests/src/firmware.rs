//! The firmware's ELF, built when a test first asks for it.

use elf::ElfBytes;
use elf::endian::AnyEndian;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::{env, fs};

/// What `rustup target add` must have been told; `rust-toolchain.toml` names it, so rustup normally has.
const TARGET: &str = "thumbv6m-none-eabi";
const PACKAGE: &str = "pneudrive-firmware";

/// The firmware for the RP2040, as it is flashed.
///
/// Built by cargo into a target folder of its own, so that it does not wait for the build that runs the tests. The first
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
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .args(["build", "--quiet", "--release", "--package", PACKAGE, "--target", TARGET])
        .arg("--target-dir")
        .arg(target_folder())
        .current_dir(workspace())
        // Flags meant for the host (coverage, sanitizers) do not suit the chip.
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .status();
    match status {
        Ok(status) if status.success() => artefact(),
        Ok(status) => panic!("building {PACKAGE} for {TARGET} failed ({status}); is the target installed?"),
        Err(error) => panic!("cannot run cargo to build {PACKAGE}: {error}"),
    }
}

fn artefact() -> PathBuf {
    target_folder().join(TARGET).join("release").join(PACKAGE)
}

fn target_folder() -> PathBuf {
    let host = env::var_os("CARGO_TARGET_DIR").map_or_else(|| workspace().join("target"), PathBuf::from);
    host.join("firmware")
}

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The firmware with one instruction of a function replaced: what a fault in the program would do.
///
/// `function` is a part of its mangled name; the first halfword of the function becomes `instruction`.
///
/// # Panics
/// If there is not exactly one such function.
pub fn with_broken(function: &str, instruction: u16) -> Vec<u8> {
    let mut elf = elf().to_vec();
    let offset = file_offset_of(&elf, function);
    elf[offset..offset + 2].copy_from_slice(&instruction.to_le_bytes());
    elf
}

fn file_offset_of(bytes: &[u8], function: &str) -> usize {
    let fail = |why: &str| -> ! { panic!("looking for {function} in the firmware: {why}") };
    let Ok(file) = ElfBytes::<AnyEndian>::minimal_parse(bytes) else { fail("not an ELF file") };
    let Ok(Some((symbols, names))) = file.symbol_table() else { fail("no symbols") };
    let found: Vec<u64> = symbols
        .iter()
        .filter(|symbol| symbol.st_symtype() == elf::abi::STT_FUNC)
        .filter(|symbol| names.get(symbol.st_name as usize).is_ok_and(|name| name.contains(function)))
        // Bit 0 says that it is Thumb code.
        .map(|symbol| symbol.st_value & !1)
        .collect();
    let [address] = found[..] else { fail(&format!("{} functions have this name", found.len())) };
    let Some(segments) = file.segments() else { fail("no segments") };
    segments
        .iter()
        .find(|segment| (segment.p_vaddr..segment.p_vaddr + segment.p_filesz).contains(&address))
        .map(|segment| (segment.p_offset + address - segment.p_vaddr) as usize)
        .unwrap_or_else(|| fail("it is in no segment"))
}
