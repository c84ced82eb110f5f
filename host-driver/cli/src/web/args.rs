use clap::{Args, ValueEnum};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;

/// A live page of the run.
#[derive(Debug, Clone, PartialEq, Args)]
#[command(next_help_heading = "Live page")]
pub struct WebArgs {
    /// Serve a page of the run for browsers, with a vent button
    ///
    /// Without an address, or with a port only, this computer alone can see it: 127.0.0.1:8080.
    #[arg(long, value_name = "[ADDR:]PORT", num_args = 0..=1, default_missing_value = "8080", value_parser = address)]
    pub web: Option<SocketAddr>,
    /// Name under which browsers ask for the page, besides addresses, localhost and this computer's
    /// own name; may be repeated
    #[arg(long, value_name = "NAME", requires = "web", hide_short_help = true)]
    pub web_name: Vec<String>,
    /// Let clients that have the token set pressures on the page and release a vent. The token is
    /// part of the address that is printed
    #[arg(long, requires = "web", hide_short_help = true)]
    pub allow_control: bool,
    /// Highest pressure that the page may command, kPa, up to the full scale of the boards'
    /// sensors [default: 200]
    #[arg(long, value_name = "KPA", requires = "allow_control", hide_short_help = true, value_parser = limit)]
    pub control_limit: Option<f64>,
    /// Take the token from this file's only line, and print none
    #[arg(long, value_name = "FILE", requires = "allow_control", hide_short_help = true)]
    pub control_token_file: Option<PathBuf>,
    /// Deadman mode for everybody who sets pressures on the page: all boards vent when the
    /// operator's page has been closed, hidden or out of reach for this long. Without it, the
    /// operator may ask for it on the page, with 3 s
    #[arg(long, value_name = "SECONDS", requires = "allow_control", hide_short_help = true, value_parser = deadman)]
    pub web_deadman: Option<f64>,
    /// Where the page's recording button puts its files [default: the working folder; none if
    /// others can reach the page, or nothing can be written there]
    #[arg(long, value_name = "FOLDER", requires = "web", hide_short_help = true)]
    pub record_folder: Option<PathBuf>,
    /// What the page's recording button makes
    #[arg(long, value_enum, requires = "web", hide_short_help = true, default_value_t = RecordFormat::CsvZst)]
    pub record_format: RecordFormat,
}

impl WebArgs {
    /// What the page may command unless something else is asked for, kPa.
    pub const CONTROL_LIMIT_KPA: f64 = 200.0;
}

impl Default for WebArgs {
    fn default() -> Self {
        Self {
            web: None,
            web_name: Vec::new(),
            allow_control: false,
            control_limit: None,
            control_token_file: None,
            web_deadman: None,
            record_folder: None,
            record_format: RecordFormat::CsvZst,
        }
    }
}

/// Formats of recordings by button.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum RecordFormat {
    /// Text, larger
    #[value(name = "csv")]
    Csv,
    /// Text, compressed
    #[value(name = "csv.gz")]
    CsvGz,
    /// Text, compressed
    #[value(name = "csv.zst")]
    CsvZst,
    /// ROS 2 bag: a folder with an MCAP file and its metadata.yaml
    #[value(name = "mcap")]
    Mcap,
}

impl RecordFormat {
    /// How the names of such files end.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::CsvGz => "csv.gz",
            Self::CsvZst => "csv.zst",
            Self::Mcap => "mcap",
        }
    }
}

/// An address with its port, or a port of this computer's own address.
fn address(text: &str) -> Result<SocketAddr, String> {
    let port = text.parse().map(|port| SocketAddr::from((Ipv4Addr::LOCALHOST, port))).ok();
    port.or_else(|| text.parse().ok()).ok_or_else(|| {
        "expected ADDRESS:PORT such as 127.0.0.1:8080, 0.0.0.0:8080 (all addresses) or [::]:8080, or a port".to_owned()
    })
}

fn limit(text: &str) -> Result<f64, String> {
    // What the sensors' full scale is, a rig file says.
    match text.parse() {
        Ok(kpa) if kpa > 0.0 && f64::is_finite(kpa) => Ok(kpa),
        _ => Err("must be a number of kPa above 0".to_owned()),
    }
}

/// A page says ten times within this time that it is there.
fn deadman(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (0.5..=60.0).contains(&seconds) => Ok(seconds),
        _ => Err("must be 0.5 to 60 s".to_owned()),
    }
}
