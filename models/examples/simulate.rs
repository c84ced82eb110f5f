//! Simulates a recording from its drives alone, with parameters fitted to its first half.

use std::error::Error;
use std::path::Path;

use pneudrive_model::data::{LoadOptions, load};
use pneudrive_model::experiment::{FitSettings, Split, fit_channels};
use pneudrive_model::fit::Control;
use pneudrive_model::rig::Rig;
use pneudrive_model::simulation::{CalibratedModel, SimulationSettings, simulate};
use pneudrive_model::store::ParameterFile;

fn main() -> Result<(), Box<dyn Error>> {
    let data = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/data"));
    let rig = Rig::load(&data.join("rig.toml"))?;
    let recording = load(&data.join("chamber.csv"), LoadOptions::default())?.recording;
    let settings = FitSettings { split: Some(Split::FitFraction(0.5)), ..FitSettings::default() };
    let fitted = fit_channels(&recording, &rig, &settings, Control::none())?;

    // Or CalibratedModel::load(path) of what `fit` or `diagnose` saved.
    let model = CalibratedModel::from(ParameterFile::of(&recording, &rig, &settings, &fitted)?);
    let simulation = simulate(&model, &recording, &SimulationSettings::default(), &mut |_, _| {})?;
    for channel in &simulation.channels {
        let (low_kpa, high_kpa) = channel.range_kpa();
        println!("{}, {}: {low_kpa:.1} to {high_kpa:.1} kPa", channel.id, channel.model.words());
        println!("{:?}", channel.score);
    }
    Ok(())
}
