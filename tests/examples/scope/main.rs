//! The pictures of docs/bring-up.md: what a scope should show, drawn from the emulated chip's own
//! pins.
//!
//! `cargo run -p system-tests --example scope -- docs/bring-up`

mod capture;
mod pictures;
mod svg;

use std::path::PathBuf;
use std::{env, fs};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder: PathBuf = env::args_os().nth(1).ok_or("usage: scope FOLDER")?.into();
    fs::create_dir_all(&folder)?;
    let pictures = [
        ("reset.svg", pictures::reset()),
        ("answer.svg", pictures::answer()),
        ("pwm.svg", pictures::pwm()),
        ("answer-times.svg", pictures::answer_times()),
    ];
    for (name, picture) in pictures {
        let path = folder.join(name);
        fs::write(&path, picture)?;
        println!("{}", path.display());
    }
    Ok(())
}
