//! `pneudrive-model show`

use std::path::{Path, PathBuf};

use pneudrive_model::data::{ChannelId, Event, Source, events, write};
use pneudrive_model::overview::{ChannelFigures, figures, recording_page};
use serde::Serialize;

use super::print::outln;
use super::{Failure, input, interrupt, origin, output, target};

/// Show a recording on one page: pressures, set points, deviations, losses, events
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
pneudrive-model show run.csv.zst\n  \
pneudrive-model show run.mcap --channels b0c0,b0c1 --out pages/run.html\n\n\
Writes one self-contained HTML page, and its figures as JSON beside it.")]
pub struct Args {
    /// Recording: CSV, plain or compressed with gzip or zstd, or MCAP (a ROS 2 bag)
    #[arg(value_name = "RUN")]
    data: PathBuf,
    /// The page [default: the recording's name with .html, in the current folder]
    #[arg(long, value_name = "FILE.html")]
    out: Option<PathBuf>,
    /// Rig description (TOML) [default: the copy that RUN carries]: with its sensors, samples at
    /// their limits are masked
    #[arg(long, value_name = "RIG.toml")]
    rig: Option<PathBuf>,
    /// Channels to show, as in b0c0,b0c1 [default: all]
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',')]
    channels: Vec<ChannelId>,
}

const SCHEMA: &str = "pneudrive-show/1";

#[derive(Serialize)]
struct Output<'a> {
    schema: &'static str,
    data: &'a Source,
    seconds: f64,
    rate_hz: f64,
    rows: usize,
    channels: &'a [ChannelFigures],
    events: &'a [Event],
    notes: Vec<String>,
}

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        let html = self.out.clone().unwrap_or_else(|| page_beside(&self.data));
        let json = html.with_extension("json");
        let inputs: Vec<&Path> = std::iter::once(&self.data).chain(&self.rig).map(PathBuf::as_path).collect();
        target::file("--out", &html, &inputs)?;
        target::ending("--out", &html, "a page is", &[".html", ".htm"])?;
        target::json("--out", &json, SCHEMA, &inputs)?;
        let rig = input::rig(self.rig.as_deref(), &self.data)?;
        let loaded = input::recording(&self.data, &self.channels, &rig)?;
        let happened = events(&self.data)?;
        let from = origin::origin();
        let footer = format!(
            "{} | {} | {} | SHA-256 {}",
            from.program, from.created, from.command, loaded.recording.source.sha256
        );
        let page = recording_page(&loaded, &happened, &footer)?;
        write::text_atomically(&html, &page)?;
        let content = Output {
            schema: SCHEMA,
            data: &loaded.recording.source,
            seconds: loaded.recording.duration_s(),
            rate_hz: loaded.recording.rate_hz(),
            rows: loaded.recording.rows(),
            channels: &figures(&loaded.recording),
            events: &happened,
            notes: loaded.quality.sentences(),
        };
        output::json(&json, &content)?;
        outln!("wrote {} and {}", html.display(), json.display());
        interrupt::check("these files")
    }
}

/// `run.html` for `folder/run.csv.zst`.
fn page_beside(data: &Path) -> PathBuf {
    let name = data.file_name().unwrap_or_default().to_string_lossy();
    let stem = [".gz", ".zst"].iter().find_map(|ending| name.strip_suffix(ending)).unwrap_or(&name);
    let stem = [".csv", ".mcap"].iter().find_map(|ending| stem.strip_suffix(ending)).unwrap_or(stem);
    PathBuf::from(format!("{stem}.html"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_called_as_the_recording() {
        for name in ["a/run.csv", "run.csv.gz", "run.mcap", "run"] {
            assert_eq!(page_beside(Path::new(name)), Path::new("run.html"));
        }
    }
}
