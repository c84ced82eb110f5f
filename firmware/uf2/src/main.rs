//! `cargo fw-uf2`: builds the firmware and writes it as a UF2 file for BOOTSEL.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{env, fs};

use clap::{Parser, ValueEnum};
use pneudrive_uf2::{ChipFamily, FlashImage, check_bootable, encode};

/// Builds the firmware and writes it as a UF2 file.
///
/// Hold BOOTSEL while the board is plugged in, and copy the file to the drive that appears.
#[derive(Parser)]
#[command(name = "cargo fw-uf2", version)]
struct Arguments {
    /// The chip on the board.
    #[arg(value_enum, default_value = "rp2040")]
    chip: Chip,
    /// The file to write [default: target/pneudrive-CHIP.uf2]
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Converts this ELF file instead of building the firmware.
    #[arg(long)]
    elf: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Chip {
    Rp2040,
    Rp2350,
}

impl Chip {
    fn name(self) -> &'static str {
        match self {
            Self::Rp2040 => "rp2040",
            Self::Rp2350 => "rp2350",
        }
    }

    fn target(self) -> &'static str {
        match self {
            Self::Rp2040 => "thumbv6m-none-eabi",
            Self::Rp2350 => "thumbv8m.main-none-eabihf",
        }
    }

    fn family(self) -> ChipFamily {
        match self {
            Self::Rp2040 => ChipFamily::Rp2040,
            Self::Rp2350 => ChipFamily::Rp2350,
        }
    }
}

fn main() -> ExitCode {
    match run(Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: Arguments) -> Result<(), Box<dyn Error>> {
    let Arguments { chip, output, elf } = arguments;
    let elf = match elf {
        Some(path) => path,
        None => build(chip)?,
    };
    let bytes = fs::read(&elf).map_err(|error| format!("cannot read {}: {error}", elf.display()))?;
    let image = FlashImage::from_elf(&bytes).map_err(|error| format!("{}: {error}", elf.display()))?;
    check_bootable(&image, chip.family()).map_err(|error| format!("{}: {error}", elf.display()))?;
    let output = output.unwrap_or_else(|| target_folder().join(format!("pneudrive-{}.uf2", chip.name())));
    let uf2 = encode(&image, chip.family());
    fs::write(&output, &uf2).map_err(|error| format!("cannot write {}: {error}", output.display()))?;
    let (flash, ram) = (image.bytes().len(), image.static_ram());
    println!("{}: {flash} bytes of flash, {ram} bytes of RAM and a stack", output.display());
    Ok(())
}

/// As `cargo fw-build` and `cargo fw-2350-build` do.
fn build(chip: Chip) -> Result<PathBuf, Box<dyn Error>> {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .args(["build", "--release", "-p", "pneudrive-firmware", "--target", chip.target()])
        .args(["--no-default-features", "--features", chip.name()])
        .current_dir(workspace())
        .status()?;
    if !status.success() {
        return Err(format!("the firmware for {} was not built", chip.name()).into());
    }
    Ok(target_folder().join(chip.target()).join("release").join("pneudrive-firmware"))
}

fn target_folder() -> PathBuf {
    env::var_os("CARGO_TARGET_DIR").map_or_else(|| workspace().join("target"), PathBuf::from)
}

/// Two folders above this package's.
fn workspace() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap_or(Path::new("."))
}
