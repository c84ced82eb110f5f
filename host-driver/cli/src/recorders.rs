//! The recordings of a run: of all of it, by argument, or of parts, by key.

use crate::args::{BusArgs, RunArgs};
use crate::failure::Failure;
use crate::setup::Setup;
use crate::view::{self, Events, KeyRecorder};
use pneudrive_host::poller::Observer;
use pneudrive_record::{Description, RecordError, Recorder, RecorderOptions, RecordingSummary};

/// What records beside a run.
pub struct Recorders {
    whole: Option<Recorder>,
    by_key: Option<KeyRecorder>,
}

impl Recorders {
    /// Begins the recording that the arguments name; without one, where keys are read, what begins
    /// one by key. Their observers go among the others.
    pub fn begin(
        args: &BusArgs,
        run: &RunArgs,
        (boards, setup): (&[u8], &Setup),
        description: Description,
        events: &Events,
        observers: &mut Vec<Box<dyn Observer>>,
    ) -> Result<Self, Failure> {
        if let Some(path) = &run.record {
            let how = RecorderOptions::default()
                .overwrite(run.overwrite)
                .pages(run.pages())
                .ambient_kpa(setup.ambient_kpa())
                .description(description);
            let (recorder, tap) = Recorder::create_with(path, boards, setup.calibration.clone(), &how)?;
            observers.push(tap);
            events.sender().record(recorder.notes());
            return Ok(Self { whole: Some(recorder), by_key: None });
        }
        let by_key = view::wants_live(args.json, run.plain).then(|| {
            let (by_key, tap) = KeyRecorder::new(boards, setup, &description, run.pages());
            observers.push(tap);
            events.sender().record(by_key.notes());
            by_key
        });
        Ok(Self { whole: None, by_key })
    }

    /// What the view's key begins and ends.
    pub fn by_key(&self) -> Option<KeyRecorder> {
        self.by_key.clone()
    }

    /// Whether the recording of the whole run cannot go on.
    pub fn has_failed(&self) -> bool {
        self.whole.as_ref().is_some_and(Recorder::has_failed)
    }

    /// Ends what is under way.
    pub fn finish(self) -> Result<Option<RecordingSummary>, RecordError> {
        let whole = self.whole.map(Recorder::finish).transpose()?;
        let by_key = self.by_key.map_or(Ok(None), |recorder| recorder.finish())?;
        Ok(whole.or(by_key))
    }
}
