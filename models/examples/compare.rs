//! Fits all three models to the first 80 % of a recording and judges them on the rest.

use std::error::Error;
use std::path::Path;

use pneudrive_model::data::{LoadOptions, load};
use pneudrive_model::experiment::{CompareSettings, CompareWatch, compare, comparison_text};
use pneudrive_model::rig::Rig;

fn main() -> Result<(), Box<dyn Error>> {
    let data = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/data"));
    let rig = Rig::load(&data.join("rig.toml"))?;
    let recording = load(&data.join("chamber.csv"), LoadOptions::default())?.recording;

    let comparison = compare(&recording, &rig, &CompareSettings::default(), CompareWatch::none())?;
    println!("{}", comparison_text(&comparison));
    Ok(())
}
