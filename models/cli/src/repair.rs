//! `pneudrive-model repair`

use std::path::{Path, PathBuf};

use pneudrive_model::data::{RepairError, repair};

use super::Failure;
use super::print::outln;

/// Close a bag whose recording was killed, so that `ros2 bag` and others open it
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
pneudrive-model repair run.mcap\n  \
pneudrive-model repair run.mcap --out runs/whole\n\n\
Every message that is whole is kept; RUN.mcap stays as it is. Tables (.csv, .csv.gz, .csv.zst) that were cut off need no repair: \
all commands read them as far as they go, and so they do bags.")]
pub struct Args {
    /// Bag (MCAP) that has no end
    #[arg(value_name = "RUN.mcap")]
    bag: PathBuf,
    /// New folder for the bag and its metadata.yaml [default: the recording's name with _repaired,
    /// beside it]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        let folder = self.out.unwrap_or_else(|| folder_beside(&self.bag));
        let repaired = repair(&self.bag, &folder).map_err(|error| match error {
            RepairError::Write { .. } => Failure::running(error),
            _ => Failure::input(error),
        })?;
        let (file, count) = (repaired.file.display(), repaired.messages);
        outln!("wrote {file}: {count} messages in {:.3} s", repaired.seconds);
        match repaired.stopped {
            Some(why) => outln!("  {} stops in the middle: {why}", self.bag.display()),
            None => outln!("  {} has its end: nothing was wrong with it", self.bag.display()),
        }
        Ok(())
    }
}

/// `folder/run_repaired` for `folder/run.mcap`.
fn folder_beside(bag: &Path) -> PathBuf {
    let stem = bag.file_stem().unwrap_or_default().to_string_lossy();
    bag.with_file_name(format!("{stem}_repaired"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folder_is_called_as_the_recording() {
        assert_eq!(folder_beside(Path::new("a/run.mcap")), Path::new("a/run_repaired"));
    }
}
