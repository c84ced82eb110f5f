//! `pneudrive-model import`

use std::path::{Path, PathBuf};

use pneudrive_model::data::import::{Foreign, Mapping, TimeSource, convert};
use pneudrive_model::data::{LoadOptions, load};
use pneudrive_model::rig::Rig;

use super::print::outln;
use super::{Failure, target};

/// Convert a foreign CSV file to the measured-data format
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
pneudrive-model import log.csv --time 'time [ms]:ms' --map 'b0_p0_kpa=Pressure (psi):psi' \\\n      \
--map 'b0_cmd0_kpa=Set:psi' --out run.csv\n  \
pneudrive-model import log.csv --rate 100 --map 'b0_p0_kpa=P1:mbar-abs' \\\n      \
--map 'b0_u0=PWM:255:0' --out run.csv.gz\n  \
pneudrive-model import adc.csv --time '#1:us' --map 'b0_p0_kpa=#2:counts' \\\n      \
--rig rig.toml --out run.csv\n\n\
A mapping is TARGET=SOURCE:UNIT or TARGET=SOURCE:UNIT:OFFSET; OFFSET is taken off in the source's unit.\n\
Pressures: kPa, Pa, hPa, MPa, bar, mbar, psi, cmH2O, mmHg, any of them with -abs for absolute pressure, counts.\n\
Drives: 1, percent, counts. Angles: rad, deg. Times: s, ms, us, ns, min.\n\
A number as UNIT is the source's value for one of the target: PWM:255 makes 255 a full drive.")]
pub struct Args {
    /// File to convert (plain, gzip or zstd)
    #[arg(value_name = "FILE")]
    input: PathBuf,
    /// Recording to write: .csv, .csv.gz or .csv.zst
    #[arg(long, value_name = "FILE.csv")]
    out: PathBuf,
    /// Replace a recording that is there
    #[arg(long)]
    overwrite: bool,
    /// Time column and its unit, as in 'time [ms]:ms'
    #[arg(long, value_name = "SOURCE:UNIT", conflicts_with = "rate", required_unless_present = "rate")]
    time: Option<String>,
    /// Sampling rate, Hz, of a file without a time column
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// A column, as in 'b0_p0_kpa=Pressure (psi):psi'; repeatable. #3 names the third column
    #[arg(long = "map", value_name = "TARGET=SOURCE:UNIT", required = true)]
    maps: Vec<String>,
    /// Keep the time as it is instead of starting at 0
    #[arg(long)]
    keep_time: bool,
    /// Between two cells: one character, or `tab`
    #[arg(long, default_value = ",")]
    delimiter: String,
    /// Numbers have a decimal comma
    #[arg(long)]
    decimal_comma: bool,
    /// Lines to skip before the header
    #[arg(long, value_name = "LINES", default_value_t = 0)]
    skip: usize,
    /// Rig file: what a count is, and the air pressure that absolute pressures are reduced by
    #[arg(long, value_name = "RIG.toml")]
    rig: Option<PathBuf>,
}

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        let inputs: Vec<&Path> =
            std::iter::once(&self.input).chain(&self.rig).map(PathBuf::as_path).collect();
        target::file("--out", &self.out, &inputs)?;
        if self.out.exists() && !self.overwrite {
            let out = self.out.display();
            return Err(Failure::input(format!("{out} exists; choose another name, or pass --overwrite")));
        }
        let rig = self.rig.as_deref().map(Rig::load).transpose()?.unwrap_or_default();
        let time = match (&self.time, self.rate) {
            (Some(text), _) => TimeSource::Column(Mapping::parse_time(text)?),
            (None, Some(hz)) if hz > 0.0 && hz.is_finite() => TimeSource::Rate(hz),
            (None, _) => return Err(Failure::input("--rate must be a number of Hz above 0")),
        };
        let foreign = Foreign {
            delimiter: self.delimiter()?,
            decimal_comma: self.decimal_comma,
            skip_lines: self.skip,
            from_zero: !self.keep_time,
            time,
            columns: self.maps.iter().map(|text| Mapping::parse(text)).collect::<Result<_, _>>()?,
            rig,
        };
        let imported = convert(&self.input, &self.out, &foreign)?;
        outln!("wrote {}: {} rows from {}", self.out.display(), imported.rows, imported.source.file);
        // What a later command will say about it, while the source is at hand.
        let limits = |channel| foreign.rig.sensor_limits(channel);
        let loaded = load(
            &self.out,
            LoadOptions {
                limits: Some(&limits),
                supply_kpa: foreign.rig.supply_kpa(),
                ..LoadOptions::default()
            },
        )?;
        for sentence in loaded.quality.sentences() {
            outln!("  {sentence}");
        }
        Ok(())
    }

    fn delimiter(&self) -> Result<u8, Failure> {
        match self.delimiter.as_str() {
            "tab" | "\\t" | "\t" => Ok(b'\t'),
            text if text.len() == 1 => Ok(text.as_bytes()[0]),
            text => {
                Err(Failure::input(format!("--delimiter \"{text}\": expected one ASCII character, or tab")))
            }
        }
    }
}
