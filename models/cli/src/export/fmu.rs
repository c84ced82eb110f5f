//! `pneudrive-model export fmu`

use std::fs::File;
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};

use pneudrive_model::export::fmi::{IDENTIFIER, PARAMETERS_FILE, SETTINGS_FILE, Settings, model_description};
use pneudrive_model::simulation::CalibratedModel;
use sha2::{Digest, Sha256};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::library::{FILE, LibraryArgs};
use super::{Failure, input, target};
use crate::origin::origin;
use crate::print::outln;

/// An FMI 3.0 unit for co-simulation: one zip with the library and the parameter file
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
pneudrive-model export fmu --parameters extended.toml --out chambers.fmu\n  \
pneudrive-model export fmu --parameters extended.toml --out chambers.fmu \\\n      \
--also target/aarch64-unknown-linux-gnu/release/libpneudrive_capi.so\n\n\
Each channel of the file has the inputs set_point (or fill and vent, with --drive), supply, volume and volume_rate, and the outputs \
pressure, port, reading, temperature, spool and rate, as in b0c0.pressure. The unit needs nothing on the importer's machine but a \
platform that a library was given for.")]
pub struct Args {
    /// Parameter file that `fit` wrote, or extended.toml that `diagnose` wrote
    #[arg(long, value_name = "FILE.toml")]
    parameters: PathBuf,
    /// Unit to write
    #[arg(long, value_name = "FILE.fmu")]
    out: PathBuf,
    /// Internal step, s; communication steps are whole multiples of it
    #[arg(long, value_name = "S", default_value_t = 0.001)]
    step: f64,
    /// The valves' drives are inputs, in place of set points
    #[arg(long)]
    drive: bool,
    #[command(flatten)]
    library: LibraryArgs,
    /// The library for another platform, too; may be given several times
    #[arg(long, value_name = "FILE")]
    also: Vec<PathBuf>,
}

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        if !(1e-5..=1.0).contains(&self.step) {
            return Err(Failure::input(format!("--step {}: 0.00001 to 1 s are possible", self.step)));
        }
        target::file("--out", &self.out, &[&self.parameters])?;
        let model = input::calibrated(&self.parameters)?;
        let mut libraries = vec![self.library.find()?];
        libraries.extend(self.also);
        let parameters = read(&self.parameters)?;
        let mut settings = Settings {
            token: String::new(),
            step_s: self.step,
            set_point: !self.drive,
            channels: match &model {
                CalibratedModel::Fitted { file, .. } => {
                    file.channels.keys().map(ToString::to_string).collect()
                }
                CalibratedModel::Extended { file, .. } => file.channels.keys().cloned().collect(),
            },
        };
        settings.token = token(&parameters, &settings)?;
        let text = toml::to_string(&settings).map_err(Failure::running)?;
        let description = model_description(&settings, model.rig(), &origin().created);
        let mut entries = vec![
            ("modelDescription.xml".to_owned(), description.into_bytes()),
            (format!("resources/{PARAMETERS_FILE}"), parameters),
            (format!("resources/{SETTINGS_FILE}"), text.into_bytes()),
        ];
        for path in &libraries {
            let bytes = read(path)?;
            let (platform, ending) = platform(path, &bytes)?;
            let name = format!("binaries/{platform}/{IDENTIFIER}.{ending}");
            if entries.iter().any(|(known, _)| *known == name) {
                return Err(Failure::input(format!("{}: a second library for {platform}", path.display())));
            }
            entries.push((name, bytes));
        }
        write(&self.out, &entries)?;
        outln!("wrote {}: {} in steps of {} s", self.out.display(), settings.channels.join(", "), self.step);
        Ok(())
    }
}

fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    std::fs::read(path).map_err(|e| Failure::input(format!("{}: cannot be read: {e}", path.display())))
}

/// The same for the same content.
fn token(parameters: &[u8], settings: &Settings) -> Result<String, Failure> {
    let mut hash = Sha256::new();
    hash.update(parameters);
    hash.update(toml::to_string(settings).map_err(Failure::running)?);
    Ok(hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect())
}

/// The standard's name of the platform that a library is for, and the ending of its file.
fn platform(path: &Path, bytes: &[u8]) -> Result<(&'static str, &'static str), Failure> {
    // Executable and linkable format: the machine is a number at byte 18.
    match (bytes.get(..4), bytes.get(18..20)) {
        (Some(b"\x7fELF"), Some([0x3e, 0])) => Ok(("x86_64-linux", "so")),
        (Some(b"\x7fELF"), Some([0xb7, 0])) => Ok(("aarch64-linux", "so")),
        (Some([b'M', b'Z', ..]), _) => Ok(("x86_64-windows", "dll")),
        _ => Err(Failure::input(format!(
            "{}: not a shared library for Linux (x86-64, aarch64) or Windows, as {FILE} is",
            path.display()
        ))),
    }
}

/// Writes the zip, whole or not at all.
fn write(path: &Path, entries: &[(String, Vec<u8>)]) -> Result<(), Failure> {
    let failed = |e: &dyn std::fmt::Display| Failure::running(format!("{}: {e}", path.display()));
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        let options = SimpleFileOptions::default().unix_permissions(0o755);
        zip.start_file(name.as_str(), options).map_err(|e| failed(&e))?;
        zip.write_all(bytes).map_err(|e| failed(&e))?;
    }
    let bytes = zip.finish().map_err(|e| failed(&e))?.into_inner();
    let partial = path.with_extension("fmu.part");
    let mut file = File::create(&partial).map_err(|e| failed(&e))?;
    file.write_all(&bytes).and_then(|()| file.sync_all()).map_err(|e| failed(&e))?;
    std::fs::rename(&partial, path).map_err(|e| failed(&e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_library_says_which_platform_it_is_for() {
        let mut elf = vec![0_u8; 64];
        elf[..4].copy_from_slice(b"\x7fELF");
        elf[18] = 0x3e;
        let of = |bytes: &[u8]| platform(Path::new("lib"), bytes).map(|found| found.0);
        assert_eq!(of(&elf).unwrap(), "x86_64-linux");
        elf[18] = 0xb7;
        assert_eq!(of(&elf).unwrap(), "aarch64-linux");
        assert_eq!(of(b"MZ and so on, up to twenty").unwrap(), "x86_64-windows");
        assert!(of(b"!<arch>").is_err());
    }
}
