//! A run of a poller, as its `Poller` and its controller see it.

use super::ending::Ending;
use super::guard::Rules;
use super::history::History;
use super::interruptible::Interruptible;
use super::link::Bus;
use super::owner::Owner;
use super::poller_settings::PollerSettings;
use crate::errors::PneuDriveError;
use parking_lot::Mutex;
use pneudrive_host::poller::{
    self as host, BoardCommand, CommandSource, Override, PollerOptions, SetPoints, Snapshot, VENTED,
    VentLatch,
};
use pneudrive_host::statistics::Statistics;
use pneudrive_record::trajectory::TrajectorySource;
use pyo3::prelude::*;
use std::mem;
use std::sync::Arc;

/// How boards were left.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Vented {
    /// Boards that did not confirm 0 kPa.
    pub silent: Vec<u8>,
    /// Why, if the port failed.
    pub failure: Option<String>,
}

/// A poller's run, from its start on. It outlives the port.
pub struct Session {
    owner: Owner,
    devices: u16,
    commands: Commands,
    rules: Rules,
    vent: VentLatch,
    history: History,
    /// Held for an instant.
    run: Mutex<Run>,
}

/// Who says what is commanded.
enum Commands {
    /// Whoever sets it.
    SetPoints(SetPoints),
    /// A trajectory, until the boards are vented; after the release, whoever sets it.
    Trajectory(Override),
}

struct Run {
    /// `None` once it is to end.
    poller: Option<host::Poller<Interruptible>>,
    /// Set then.
    end: Option<End>,
    statistics: Arc<Mutex<Option<Statistics>>>,
    told: bool,
}

struct End {
    why: String,
    ending: Ending<Vented>,
}

impl Session {
    /// Starts polling on a thread of its own, with the commands of `trajectory` if there is one.
    ///
    /// # Errors
    /// The system has no thread to give.
    pub fn start(
        bus: Bus,
        settings: &PollerSettings,
        rules: &Rules,
        resume: bool,
        trajectory: Option<TrajectorySource>,
    ) -> PyResult<Arc<Self>> {
        let boards = usize::from(settings.devices);
        let (commands, source, vent): (_, Box<dyn CommandSource>, _) = match trajectory {
            None => {
                let points = SetPoints::new(boards);
                (Commands::SetPoints(points.clone()), Box::new(points), VentLatch::default())
            }
            Some(trajectory) => {
                let hand = Override::following(boards).with_limits(
                    &rules.boards,
                    rules.limits.clone(),
                    rules.calibration.clone(),
                );
                let source = hand.over(Box::new(trajectory));
                let latch = hand.latch();
                (Commands::Trajectory(hand), source, latch)
            }
        };
        let history = History::new(settings.history_s, settings.sensors.is_some());
        let options = PollerOptions::for_devices(settings.devices)
            .pace(settings.pace)
            .limits(rules.limits.clone())
            .calibration(rules.calibration.clone())
            .resume(resume)
            .line_rate(settings.line_rate)
            .sensors(settings.sensors)
            .vent(vent.clone());
        let observers: Vec<Box<dyn host::Observer>> =
            vec![Box::new(history.writer(rules.calibration.clone()))];
        let poller = host::Poller::start(bus, options, source, observers)
            .map_err(|error| PneuDriveError::new_err(error.to_string()))?;
        let run = Run { poller: Some(poller), end: None, statistics: Arc::default(), told: false };
        Ok(Arc::new(Self {
            owner: Owner::this_process(),
            devices: settings.devices,
            commands,
            rules: rules.clone(),
            vent,
            history,
            run: Mutex::new(run),
        }))
    }

    /// Who may use it. To be checked before anything else: locks mean nothing in a forked child.
    pub fn owner(&self) -> Owner {
        self.owner
    }

    /// Commands `board`, whose number is its index, from its next exchange on.
    ///
    /// # Errors
    /// Why it cannot be commanded by hand.
    pub fn set(&self, board: u8, command: BoardCommand) -> Result<(), String> {
        let index = usize::from(board);
        match &self.commands {
            Commands::SetPoints(points) => points.set(index, command).map_err(|error| error.to_string()),
            Commands::Trajectory(hand) => {
                let mut channels = command.into_iter().enumerate();
                channels.try_for_each(|(channel, counts)| {
                    hand.set(index, channel, counts).map_err(|error| error.to_string())
                })
            }
        }
    }

    /// Highest set points, fastest changes, and what counts mean.
    pub fn rules(&self) -> &Rules {
        &self.rules
    }

    /// Closed while 0 kPa is commanded, whatever the set points are.
    pub fn vent(&self) -> &VentLatch {
        &self.vent
    }

    /// Follows set points again: those that are set from now on, 0 kPa until then.
    pub fn release(&self) {
        match &self.commands {
            Commands::SetPoints(points) => {
                for board in 0..usize::from(self.devices) {
                    // All these boards exist.
                    let _ = points.set(board, VENTED);
                }
                self.vent.release();
            }
            Commands::Trajectory(hand) => hand.release(),
        }
    }

    /// What its end without a failure is called: a trajectory comes to its end by itself.
    pub fn natural_end(&self) -> &'static str {
        match &self.commands {
            Commands::SetPoints(_) => "it failed",
            Commands::Trajectory(_) => "the trajectory has ended",
        }
    }

    /// What has happened.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// Whether the boards are polled: it was not told to end, and has not failed.
    pub fn is_polling(&self) -> bool {
        self.run.lock().poller.as_ref().is_some_and(|poller| !poller.is_finished())
    }

    /// Begins the end, if it has not begun: 0 kPa to all boards, then the port is closed. `why` is
    /// what is said of it, unless the port has failed before.
    pub fn end(&self, why: &str) -> Ending<Vented> {
        let mut run = self.run.lock();
        if let Some(end) = &run.end {
            return end.ending.clone();
        }
        let (poller, statistics) = (run.poller.take(), Arc::clone(&run.statistics));
        let ending = Ending::start(move || {
            let finished = poller.map(host::Poller::stop);
            let Some(Ok(finished)) = finished else {
                let failure = Some("the polling thread failed".to_owned());
                return Vented { silent: Vec::new(), failure };
            };
            *statistics.lock() = Some(finished.statistics);
            Vented { silent: finished.not_safe, failure: finished.error.map(|error| error.to_string()) }
        });
        run.end = Some(End { why: why.to_owned(), ending: ending.clone() });
        ending
    }

    /// Whether nobody has been told yet how the boards were left; from now on somebody has.
    pub fn tell(&self) -> bool {
        !mem::replace(&mut self.run.lock().told, true)
    }

    /// Why it has ended, if it has.
    pub fn why_ended(&self) -> Option<String> {
        let run = self.run.lock();
        let end = run.end.as_ref()?;
        let failure = end.ending.peek().and_then(|vented| vented.failure);
        Some(failure.unwrap_or_else(|| end.why.clone()))
    }

    /// The newest row, while it polls.
    pub fn latest(&self) -> Option<Snapshot> {
        self.run.lock().poller.as_ref().map(host::Poller::latest)
    }

    /// What the run has been like.
    pub fn statistics(&self) -> Option<Statistics> {
        let run = self.run.lock();
        match &run.poller {
            Some(poller) => poller.statistics(),
            None => run.statistics.lock().clone(),
        }
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        if self.owner.is_other_process() {
            // Its thread is the parent's.
            let run = self.run.get_mut();
            mem::forget(run.poller.take());
            mem::forget(run.end.take());
        }
    }
}
