//! Puts the memory map where the linker finds it, and passes the linker scripts.
//!
//! Here and not in `.cargo/config.toml`, because a RUSTFLAGS in the environment replaces the flags
//! given there; and without `link-rp.x` the RP2040's boot block ends up at the wrong address
//! without a word.

use std::{env, error::Error, fs, path::PathBuf};

const MEMORY: &str = "../memory.x";
const RP2040_SECTIONS: &str = "program.x";
const RAM_SECTIONS: &str = "ram.x";
const RP2350_SECTIONS: &str = "rp2350.x";

fn main() -> Result<(), Box<dyn Error>> {
    let rp2040 = env::var_os("CARGO_FEATURE_RP2040").is_some();
    let rp2350 = env::var_os("CARGO_FEATURE_RP2350").is_some();
    // `--nmagic`: do not align sections to pages, flash has none. `link-rp.x` comes from embassy-rp
    // and puts the boot loader into a region that `link.x` has named; `program.x` and `ram.x` take
    // the code before `link.x` puts it into flash; `rp2350.x` sets where the program starts before
    // `link.x` provides that. `src/chip/rp2040/start.rs` says why `__pre_init` is wrapped.
    let arguments: &[&str] = match (rp2040, rp2350) {
        (true, false) => {
            &["--nmagic", "--wrap=__pre_init", "-Tprogram.x", "-Tlink.x", "-Tdefmt.x", "-Tlink-rp.x"]
        }
        (false, true) => &["--nmagic", "--defsym=RP2350=1", "-Tram.x", "-Trp2350.x", "-Tlink.x", "-Tdefmt.x"],
        _ => {
            return Err(
                "choose one chip: --features rp2040, or --no-default-features --features rp2350".into()
            );
        }
    };
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo sets OUT_DIR")?);
    fs::copy(MEMORY, out.join("memory.x"))?;
    for sections in [RP2040_SECTIONS, RAM_SECTIONS, RP2350_SECTIONS] {
        fs::copy(sections, out.join(sections))?;
    }
    for file in [MEMORY, RP2040_SECTIONS, RAM_SECTIONS, RP2350_SECTIONS, "build.rs"] {
        println!("cargo:rerun-if-changed={file}");
    }
    println!("cargo:rustc-link-search={}", out.display());

    for argument in arguments {
        println!("cargo:rustc-link-arg-bins={argument}");
        println!("cargo:rustc-link-arg-tests={argument}");
    }
    println!("cargo:rustc-link-arg-tests=-Tembedded-test.x");
    Ok(())
}
