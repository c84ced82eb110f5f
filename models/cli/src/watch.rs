//! `pneudrive-model watch`

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use pneudrive_model::data::{ChannelId, DataError, LiveTable, Opening};
use pneudrive_model::watch::{
    Rows, Sample, THRESHOLD, WatchEvent, WatchSettings, Watcher, columns_of, samples_of,
};
use serde::Serialize;

use super::print::outln;
use super::watch_words::{changed, learnt};
use super::{Failure, input, interrupt, print};

/// How often the end of a growing recording is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// Exit status when something has changed.
const CHANGED: u8 = 3;

/// Watch a rig beside its calibrated model: what has changed, which effect, since when
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
pneudrive-model watch run.csv.zst --follow --parameters rig.fit.toml\n  \
pneudrive-model watch run.csv.zst --parameters diagnosis/extended.toml --json\n  \
pneudrive-host --rig rig.toml --record run.csv.zst &\n  \
sleep 2; pneudrive-model watch run.csv.zst --follow --parameters p.toml\n\n\
The first stretch (--learn) says what is usual; a change after it is said with what it may be, and is then usual in turn.\n\
With --json an object a line: kind is begin, learnt, changed or end. docs/watch.md says what is found, and how fast.\n\
Exit status: 0 nothing changed, 3 something changed, 1 failed while running, 2 unusable arguments or input.")]
pub struct Args {
    /// Recording: CSV, plain or compressed (gzip, zstd); MCAP when it is finished; - for a CSV from
    /// standard input
    #[arg(value_name = "DATA")]
    data: PathBuf,
    /// Calibrated model: parameter file that `fit` wrote, or extended.toml that `diagnose` wrote
    #[arg(long, value_name = "FILE.toml")]
    parameters: PathBuf,
    /// DATA is being recorded: go on until the recording ends, or Ctrl-C
    #[arg(long)]
    follow: bool,
    /// Length of the stretch that what is usual is learnt from, s: at least 150, with movements as
    /// they are later
    #[arg(long, value_name = "S", default_value_t = 600.0, value_parser = seconds)]
    learn: f64,
    /// End at the first change
    #[arg(long)]
    until_change: bool,
    /// One JSON object a line instead of sentences
    #[arg(long)]
    json: bool,
    /// Channels to watch, as in b0c0,b0c1 [default: all that are calibrated]
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',')]
    channels: Vec<ChannelId>,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (150.0..=86_400.0).contains(&value) => Ok(value),
        _ => Err("expected a number of seconds from 150 to 86400".to_owned()),
    }
}

/// What is said at the end.
#[derive(Debug, Default, Serialize)]
struct Summary {
    /// Rows seen.
    rows: u64,
    /// Time that they cover, s.
    seconds: f64,
    /// Channels that are watched by then, of all that were to be.
    watching: usize,
    channels: usize,
    /// Changes found.
    changes: usize,
    /// How far what is furthest from usual stands out at the end, and what would be said.
    statistic: f64,
    threshold: f64,
    #[serde(skip)]
    began_s: Option<f64>,
}

/// A line of JSON.
#[derive(Serialize)]
struct Line<'a, T: Serialize> {
    schema: &'static str,
    /// The same in a sentence.
    text: String,
    #[serde(flatten)]
    says: &'a T,
}

/// What is said beside events.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum Frame<'a> {
    Begin(&'a Beginning),
    End(&'a Summary),
}

/// What is said at the beginning.
#[derive(Serialize)]
struct Beginning {
    /// What is to be watched.
    channels: Vec<ChannelId>,
    /// Length of the stretch that what is usual is learnt from, s.
    learn_s: f64,
}

const SCHEMA: &str = "pneudrive-watch/1";

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        let mut file = input::extended(&self.parameters)?;
        if !self.channels.is_empty() {
            for id in &self.channels {
                if !file.channels.contains_key(&id.to_string()) {
                    let known: Vec<&str> = file.channels.keys().map(String::as_str).collect();
                    return Err(Failure::input(format!(
                        "{} holds no channel {id}; it holds {}",
                        self.parameters.display(),
                        known.join(", ")
                    )));
                }
            }
            file.channels.retain(|id, _| self.channels.iter().any(|chosen| chosen.to_string() == *id));
        }
        let stop = interrupt::watch_quietly()?;
        let name = self.parameters.display().to_string();
        let settings = WatchSettings { learn_s: self.learn };
        let mut summary = Summary { threshold: THRESHOLD, ..Summary::default() };
        let watcher = if !self.follow && is_bag(&self.data) {
            let loaded = input::recording(&self.data, &[], &file.rig)?;
            let recording = &loaded.recording;
            let mut watcher =
                Watcher::new((&name, &file), columns_of(recording), settings).map_err(Failure::input)?;
            let mut samples = samples_of(recording);
            self.begin(&watcher);
            self.watch(&mut watcher, || Ok(samples.next()), stop, &mut summary)?;
            watcher
        } else {
            let mut rows = Rows::new(LiveTable::open(self.opening(stop))?);
            let columns = rows.columns().to_vec();
            let mut watcher = Watcher::new((&name, &file), columns, settings).map_err(Failure::input)?;
            self.begin(&watcher);
            self.watch(&mut watcher, || rows.next_row(), stop, &mut summary)?;
            watcher
        };
        summary.channels = watcher.watched().count();
        summary.statistic = watcher.statistic();
        self.end(&summary)
    }

    fn opening(&self, stop: &'static AtomicBool) -> Opening<'_> {
        if self.data == Path::new("-") {
            return Opening::Text(Box::new(std::io::stdin().lock()));
        }
        if !self.follow {
            return Opening::Whole(&self.data);
        }
        let wait = move || {
            std::thread::sleep(LOOK_EVERY);
            !stop.load(Ordering::SeqCst)
        };
        Opening::Growing(&self.data, Box::new(wait))
    }

    fn watch(
        &self,
        watcher: &mut Watcher,
        mut next: impl FnMut() -> Result<Option<Sample>, DataError>,
        stop: &AtomicBool,
        summary: &mut Summary,
    ) -> Result<(), Failure> {
        while !stop.load(Ordering::SeqCst) && !print::closed() {
            let Some(row) = next()? else { break };
            summary.rows += 1;
            let began_s = *summary.began_s.get_or_insert(row.t_s);
            summary.seconds = row.t_s - began_s;
            watcher.take(row, &mut |event| {
                match &event {
                    WatchEvent::Learnt(_) => summary.watching += 1,
                    WatchEvent::Changed(_) => summary.changes += 1,
                }
                self.say(&event);
            });
            if self.until_change && summary.changes > 0 {
                break;
            }
        }
        Ok(())
    }

    fn begin(&self, watcher: &Watcher) {
        let channels: Vec<ChannelId> = watcher.watched().collect();
        let names: Vec<String> = channels.iter().map(ToString::to_string).collect();
        let text = format!("what is usual on {} is learnt for {} s", names.join(", "), self.learn);
        self.tell(text, &Frame::Begin(&Beginning { channels, learn_s: self.learn }));
    }

    fn say(&self, event: &WatchEvent) {
        let text = match event {
            WatchEvent::Learnt(about) => learnt(about),
            WatchEvent::Changed(about) => changed(about),
        };
        self.tell(text, event);
    }

    fn end(&self, summary: &Summary) -> Result<(), Failure> {
        self.tell(summary.words(self.learn), &Frame::End(summary));
        if summary.changes > 0 { Err(Failure::finding(CHANGED)) } else { Ok(()) }
    }
}

impl Args {
    /// Prints a sentence, or the line of JSON in its place.
    fn tell(&self, text: String, says: &impl Serialize) {
        if !self.json {
            outln!("{text}");
        // Nothing in it can fail to be written as JSON.
        } else if let Ok(line) = serde_json::to_string(&Line { schema: SCHEMA, text, says }) {
            outln!("{line}");
        }
    }
}

impl Summary {
    fn words(&self, learn_s: f64) -> String {
        let Self { rows, seconds, channels, changes, .. } = self;
        let seen = format!("{rows} rows, {seconds:.1} s, {channels} channel(s)");
        if self.watching == 0 {
            return format!(
                "{seen}: what is usual was not learnt yet, which takes {learn_s} s (--learn, 150 at least) with pressures and drives or commands"
            );
        }
        let found = match changes {
            0 => "nothing has changed".to_owned(),
            1 => "one change".to_owned(),
            more => format!("{more} changes"),
        };
        format!("{seen}: {found} (what stands out most: {:.1}; said from {THRESHOLD} on)", self.statistic)
    }
}

/// By its first bytes; what cannot be opened is said later.
fn is_bag(path: &Path) -> bool {
    use std::io::Read;
    let mut head = [0; 5];
    path.is_file()
        && std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut head)).is_ok()
        && head == *b"\x89MCAP"
}
