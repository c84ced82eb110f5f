//! `pneudrive-model export`: a calibrated model for other simulators, one file per kind.

mod c;
mod fmu;
mod jax;
mod library;
mod mujoco;

use std::path::PathBuf;

use pneudrive_model::data::write;
use pneudrive_model::simulation::CalibratedModel;

use super::print::outln;
use super::{Failure, input, output, target};

/// Take a calibrated model into other simulators
#[derive(Debug, clap::Subcommand)]
#[command(after_help = "Examples:\n  \
pneudrive-model export c --parameters extended.toml --out chamber\n  \
pneudrive-model export fmu --parameters nonlinear.toml --out chambers.fmu\n  \
pneudrive-model export jax --parameters nonlinear.toml --out chambers\n  \
pneudrive-model export mujoco --parameters nonlinear.toml --out robot\n  \
pneudrive-model export mujoco --native --parameters nonlinear.toml --out robot")]
pub enum Command {
    C(c::Args),
    Fmu(fmu::Args),
    Jax(jax::Args),
    Mujoco(mujoco::Args),
}

impl Command {
    pub fn run(self) -> Result<(), Failure> {
        match self {
            Self::C(args) => args.run(),
            Self::Fmu(args) => args.run(),
            Self::Jax(args) => args.run(),
            Self::Mujoco(args) => args.run(),
        }
    }
}

/// What every kind needs.
#[derive(Debug, clap::Args)]
struct From {
    /// Parameter file that `fit` wrote, or extended.toml that `diagnose` wrote
    #[arg(long, value_name = "FILE.toml")]
    parameters: PathBuf,
    /// Folder to write into
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

impl From {
    /// Reads the parameter file; the folder is made later, when the rest is there too.
    fn load(&self) -> Result<CalibratedModel, Failure> {
        target::folder("--out", &self.out, &[PARAMETERS], &[&self.parameters])?;
        input::calibrated(&self.parameters)
    }

    fn make_folder(&self) -> Result<(), Failure> {
        output::folder(&self.out)
    }

    /// Writes a text into the folder.
    fn text(&self, name: &str, text: &str) -> Result<(), Failure> {
        let path = self.out.join(name);
        write::text_atomically(&path, text)?;
        outln!("wrote {}", path.display());
        Ok(())
    }

    /// Copies the parameter file into the folder.
    fn copy_parameters(&self) -> Result<(), Failure> {
        self.copy(&self.parameters, PARAMETERS)
    }

    fn copy(&self, from: &std::path::Path, name: &str) -> Result<(), Failure> {
        let to = self.out.join(name);
        std::fs::copy(from, &to).map_err(|e| {
            Failure::running(format!("{}: cannot be copied to {}: {e}", from.display(), to.display()))
        })?;
        outln!("wrote {}", to.display());
        Ok(())
    }
}

/// Name of the parameter file in an export.
const PARAMETERS: &str = "parameters.toml";
