//! Fits the nonlinear model to a recording and saves its parameters.

use std::error::Error;
use std::path::Path;

use pneudrive_model::data::{LoadOptions, load};
use pneudrive_model::experiment::{FitSettings, fit_channels};
use pneudrive_model::fit::Control;
use pneudrive_model::rig::Rig;
use pneudrive_model::store::ParameterFile;

fn main() -> Result<(), Box<dyn Error>> {
    let data = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/data"));
    let rig = Rig::load(&data.join("rig.toml"))?;
    let recording = load(&data.join("chamber.csv"), LoadOptions::default())?.recording;

    let settings = FitSettings::default();
    let fitted = fit_channels(&recording, &rig, &settings, Control::none())?;
    for channel in &fitted {
        for p in &channel.fit.parameters {
            println!("{} {} = {:.4} {} {:?}", channel.channel, p.name, p.value, p.unit, p.ci95);
        }
    }
    let file = ParameterFile::of(&recording, &rig, &settings, &fitted)?;
    file.save(&std::env::temp_dir().join("chamber.toml"))?;
    Ok(())
}
