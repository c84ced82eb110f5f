//! Progress on a terminal, plain lines elsewhere; always on standard error.

use std::io::IsTerminal;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::print::errln;
use indicatif::{ProgressBar, ProgressStyle};
use pneudrive_model::fit::Progress;

fn style(template: &str) -> ProgressStyle {
    // The templates are constants below; a mistake in one would only cost the colours.
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// Progress of reading a file; silent off a terminal.
pub struct LoadingBar(ProgressBar);

impl LoadingBar {
    pub fn new(path: &Path) -> Self {
        let bar = ProgressBar::new(0);
        bar.set_style(style("{msg} {wide_bar} {bytes}/{total_bytes}"));
        bar.set_message(format!("reading {}", path.display()));
        Self(bar)
    }

    pub fn set(&self, done: u64, size: u64) {
        self.0.set_length(size);
        self.0.set_position(done);
    }

    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}

/// Progress of a fit: a bar on a terminal, a line at each quarter elsewhere.
pub struct FitBar {
    bar: Option<ProgressBar>,
    what: String,
    quarters: AtomicUsize,
}

impl FitBar {
    pub fn new(what: String) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let bar = terminal.then(|| {
            let bar = ProgressBar::new(0);
            bar.set_style(style("{msg} {wide_bar} {pos}/{len} searches, {eta} left"));
            bar.set_message(what.clone());
            bar
        });
        if !terminal {
            errln!("{what} ...");
        }
        Self { bar, what, quarters: AtomicUsize::new(0) }
    }

    /// Called from any thread.
    pub fn set(&self, progress: Progress) {
        if let Some(bar) = &self.bar {
            bar.set_length(progress.total as u64);
            bar.set_position(progress.done as u64);
            return;
        }
        let quarter = 4 * progress.done / progress.total.max(1);
        if quarter > self.quarters.fetch_max(quarter, Ordering::Relaxed) {
            errln!("{}: {} of {} searches done", self.what, progress.done, progress.total);
        }
    }

    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
