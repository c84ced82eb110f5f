//! The program: started before anything moves, fed, listened to, ended with the run.

use super::line::{Line, Says, board_of};
use super::state::WatchStatus;
use super::tap::{self, Tap};
use super::{WatchError, program};
use crate::{Formatter, PageColumns};
use pneudrive_host::Calibration;
use pneudrive_host::notices::{Notice, NoticeKind};
use pneudrive_host::poller::Observer;
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// What is watched with.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct WatchOptions {
    /// The calibrated model: parameter file of `pneudrive-model fit`, or `extended.toml` of
    /// `diagnose`.
    pub parameters: PathBuf,
    /// The program; `None` looks for `pneudrive-model` beside this one, then on the search path.
    pub program: Option<PathBuf>,
    /// How long what is usual is learnt; `None` is the program's usual time.
    pub learn: Option<Duration>,
    /// What rows have beside commands and pressures.
    pub pages: PageColumns,
}

impl WatchOptions {
    /// Watches with this model, by the program that lies beside this one, for its usual times.
    pub fn new(parameters: impl Into<PathBuf>) -> Self {
        Self { parameters: parameters.into(), program: None, learn: None, pages: PageColumns::default() }
    }

    /// Another program; `None` looks for it.
    #[must_use]
    pub fn program(mut self, program: Option<PathBuf>) -> Self {
        self.program = program;
        self
    }

    /// Learns for so long what is usual; `None` leaves it to the program.
    #[must_use]
    pub fn learn(mut self, learn: Option<Duration>) -> Self {
        self.learn = learn;
        self
    }

    /// Rows have these pages.
    #[must_use]
    pub fn pages(mut self, pages: PageColumns) -> Self {
        self.pages = pages;
        self
    }
}

/// A watch beside a run.
#[derive(Debug)]
pub struct Watch {
    program: Child,
    status: WatchStatus,
    ending: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Watch {
    /// How long the program may take to say its last words, s.
    const LAST_WORDS: Duration = Duration::from_secs(5);

    /// Starts the program and waits until it has read the model. The observer is to be given to the
    /// poller; `tell` is called, on a thread of the watch, with everything that is found.
    ///
    /// # Errors
    /// There is no such program, or it refuses the model or these boards.
    pub fn start(
        options: &WatchOptions,
        boards: &[u8],
        calibration: &Calibration,
        tell: impl FnMut(Notice) + Send + 'static,
    ) -> Result<(Self, Box<dyn Observer>), WatchError> {
        let path = program::find(options.program.as_deref())?;
        let not_started = |reason: String| WatchError::NotStarted { program: path.clone(), reason };
        let mut program = command(&path, options).spawn().map_err(|error| not_started(error.to_string()))?;
        let (Some(mut input), Some(output)) = (program.stdin.take(), program.stdout.take()) else {
            return Err(not_started("it has no standard input and output".to_owned()));
        };
        let complaints = program.stderr.take().map(listen);
        let formatter = Formatter::new(boards, calibration, options.pages);
        // What it says where the pipe is closed is better than that.
        let _ = input.write_all(&formatter.header()).and_then(|()| input.flush());
        let mut output = BufReader::new(output);
        let mut first = String::new();
        let begun = output.read_line(&mut first).ok().filter(|count| *count > 0);
        let begun = begun.map_or(Err(String::new()), |_| Line::parse(&first));
        let line = match begun {
            Ok(line) => line,
            Err(reason) => {
                let _ = program.kill();
                let ended = program.wait().ok();
                let said = complaints.map_or_else(String::new, |thread| thread.join().unwrap_or_default());
                let reason = why(&said, &reason, ended);
                return Err(WatchError::Refused { parameters: options.parameters.clone(), reason });
            }
        };
        let status = WatchStatus::default();
        let (tap, batches) = Tap::new(status.clone());
        let ending = Arc::<AtomicBool>::default();
        let mut listener =
            Listener { status: status.clone(), ending: Arc::clone(&ending), tell: Box::new(tell) };
        listener.take(&line);
        let named = |name: &str| std::thread::Builder::new().name(name.to_owned());
        let over = Arc::clone(&ending);
        let writer = named("pneudrive-watch-w");
        let writer = writer.spawn(move || tap::write(&batches, &formatter, input, &over));
        let reader = named("pneudrive-watch-r").spawn(move || listener.run(output, complaints));
        match (writer, reader) {
            (Ok(writer), Ok(reader)) => {
                Ok((Self { program, status, ending, threads: vec![writer, reader] }, Box::new(tap)))
            }
            (Err(error), _) | (_, Err(error)) => {
                let _ = program.kill();
                Err(not_started(error.to_string()))
            }
        }
    }

    /// How it stands.
    pub fn status(&self) -> WatchStatus {
        self.status.clone()
    }

    /// Ends the program. To be called when the poller has ended (and dropped the observer).
    pub fn finish(mut self) {
        self.end();
    }

    fn end(&mut self) {
        self.ending.store(true, Ordering::SeqCst);
        let until = Instant::now() + Self::LAST_WORDS;
        // Its input has ended with the poller.
        while matches!(self.program.try_wait(), Ok(None)) && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(10));
        }
        let _ = self.program.kill();
        let _ = self.program.wait();
        self.threads.drain(..).for_each(|thread| {
            let _ = thread.join();
        });
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        if !self.threads.is_empty() {
            self.end();
        }
    }
}

fn command(path: &Path, options: &WatchOptions) -> Command {
    let mut command = Command::new(path);
    command.args(["watch", "-", "--json", "--parameters"]).arg(&options.parameters);
    if let Some(learn) = options.learn {
        command.arg("--learn").arg(learn.as_secs_f64().to_string());
    }
    // Ctrl-C is for this program: the other one ends when its rows do.
    command.process_group(0).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Collects what a program complains of, as much as is worth a message.
fn listen(mut stream: impl Read + Send + 'static) -> JoinHandle<String> {
    const MOST: usize = 4096;
    std::thread::spawn(move || {
        let (mut said, mut part) = (Vec::new(), [0; 1024]);
        while let Ok(count @ 1..) = stream.read(&mut part) {
            said.extend_from_slice(&part[..count]);
            let first = said.len().saturating_sub(MOST);
            said.drain(..first);
        }
        String::from_utf8_lossy(&said).trim().to_owned()
    })
}

/// Why a program ended.
fn why(said: &str, otherwise: &str, ended: Option<ExitStatus>) -> String {
    // The last line that says so is the error; what follows it is advice. Without one the last line
    // has to do.
    let error = said.lines().filter_map(|line| line.strip_prefix("error: ")).next_back();
    let last = error.unwrap_or_else(|| said.lines().last().unwrap_or_default());
    match (last, otherwise, ended) {
        ("", "", Some(status)) => format!("pneudrive-model watch ended ({status}) without a word"),
        ("", "", None) => "pneudrive-model watch ended without a word".to_owned(),
        ("", otherwise, _) => otherwise.to_owned(),
        (last, ..) => last.to_owned(),
    }
}

/// Hears what the program says.
struct Listener {
    status: WatchStatus,
    ending: Arc<AtomicBool>,
    tell: Box<dyn FnMut(Notice) + Send>,
}

impl Listener {
    fn run(mut self, output: BufReader<ChildStdout>, complaints: Option<JoinHandle<String>>) {
        let mut strange = String::new();
        for text in output.lines().map_while(Result::ok) {
            match Line::parse(&text) {
                Ok(line) => self.take(&line),
                Err(why) => strange = why,
            }
        }
        if !self.ending.load(Ordering::SeqCst) {
            let said = complaints.map_or_else(String::new, |thread| thread.join().unwrap_or_default());
            let why = why(&said, &strange, None);
            self.status.change(|state| state.failed = Some(why.clone()));
            (self.tell)(Notice::new(NoticeKind::WatchFailed, format!("nothing is watched any more: {why}")));
        }
    }

    fn take(&mut self, line: &Line) {
        self.status.change(|state| state.take(line));
        let (kind, board) = match &line.says {
            Says::Changed { channel, .. } => (NoticeKind::Changed, board_of(channel)),
            Says::Begin { .. } | Says::Learnt => (NoticeKind::Watch, None),
            Says::End | Says::Other => return,
        };
        (self.tell)(Notice { kind, board, text: line.text.clone() });
    }
}

#[cfg(test)]
mod tests {
    use super::why;

    #[test]
    fn the_error_is_told_and_not_the_advice_below_it() {
        let refused = "error: invalid value '60' for '--learn <S>': at least 150\n\nFor more information, try '--help'.";
        assert_eq!(why(refused, "", None), "invalid value '60' for '--learn <S>': at least 150");
        assert_eq!(why("error: p.toml: cannot be read", "odd", None), "p.toml: cannot be read");
        assert_eq!(why("memory is exhausted", "", None), "memory is exhausted");
        assert_eq!(why("", "odd", None), "odd");
        assert_eq!(why("", "", None), "pneudrive-model watch ended without a word");
    }
}
