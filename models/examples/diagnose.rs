//! Asks what the model lacks in a recording of a chamber whose flow follows the drive 30 ms late.

use std::error::Error;
use std::path::Path;

use pneudrive_model::data::{LoadOptions, load};
use pneudrive_model::diagnosis::{Request, diagnose};
use pneudrive_model::rig::Rig;

fn main() -> Result<(), Box<dyn Error>> {
    let data = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/data"));
    let rig = Rig::load(&data.join("rig.toml"))?;
    let recording = load(&data.join("chamber.csv"), LoadOptions::default())?.recording;

    let report = diagnose(&recording, &rig, Request::default(), &|_, _| {})?.report;
    println!("{}", report.sentence);
    for cause in &report.causes {
        for (name, size) in &cause.parameters {
            println!("{}: {name} = {:.4} {} {:?}", cause.effect, size.value, size.unit, size.ci95);
        }
    }
    Ok(())
}
