//! The program's log: standard error, and a queue for `/rosout`.

use crate::unix_time::unix_now_ns;
use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

/// Warnings and errors go to standard error. Those of the DDS library at most as errors: it warns
/// of every peer that comes or goes.
struct Logger {
    waiting: Mutex<VecDeque<Line>>,
}

static LOGGER: Logger = Logger { waiting: Mutex::new(VecDeque::new()) };

/// A line of the log.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// When, ns since 1970.
    pub unix_ns: u64,
    /// How bad it is.
    pub level: log::Level,
    /// What is said.
    pub text: String,
    /// Where in the source.
    pub file: &'static str,
    /// Where in that.
    pub number: u32,
}

/// Lines that may wait for `/rosout`; of more the oldest are given up.
const QUEUE: usize = 1_000;

impl log::Log for Logger {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        let ours = metadata.target().starts_with("pneudrive");
        // Asking for matched peers before there are any is an "error" to it.
        let noisy = metadata.target().starts_with("ros2_client::node");
        metadata.level() <= if ours { log::Level::Info } else { log::Level::Error } && !noisy
    }

    fn log(&self, record: &log::Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let text = record.args().to_string();
        eprintln!("{}: {text}", record.level().as_str().to_lowercase());
        // What DDS says of itself is not sent by DDS: it might be that it cannot be sent.
        if record.target().starts_with("pneudrive") {
            self.keep(Line {
                unix_ns: unix_now_ns(),
                level: record.level(),
                text,
                file: record.file_static().unwrap_or_default(),
                number: record.line().unwrap_or_default(),
            });
        }
    }

    fn flush(&self) {}
}

impl Logger {
    fn keep(&self, line: Line) {
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        if waiting.len() == QUEUE {
            waiting.pop_front();
        }
        waiting.push_back(line);
    }
}

/// Makes it the program's.
pub fn install() {
    if log::set_logger(&LOGGER).is_ok() {
        log::set_max_level(log::LevelFilter::Info);
    }
}

/// What was logged since this was last called, oldest first.
pub fn take() -> VecDeque<Line> {
    std::mem::take(&mut *LOGGER.waiting.lock().unwrap_or_else(PoisonError::into_inner))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_lines_are_given_up() {
        let logger = Logger { waiting: Mutex::default() };
        for number in 0..QUEUE as u32 + 5 {
            let level = log::Level::Info;
            logger.keep(Line { unix_ns: 0, level, text: String::new(), file: "", number });
        }
        let waiting = logger.waiting.into_inner().unwrap();
        assert_eq!((waiting.len(), waiting.front().map(|line| line.number)), (QUEUE, Some(5)));
    }
}
