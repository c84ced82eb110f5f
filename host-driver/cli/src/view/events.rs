use pneudrive_host::notices::{Notice, NoticeWriter};
use pneudrive_host::poller::{Event, Observer, Row};
use pneudrive_record::Notes;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

/// Lines about what happened, from the bus thread and others to whoever shows them.
pub struct Events {
    sender: EventSender,
    receiver: Mutex<Receiver<String>>,
    /// Others who hear what happens on the bus.
    listeners: Vec<Sender<String>>,
}

/// Adds lines, from any thread.
#[derive(Clone)]
pub struct EventSender {
    lines: Sender<String>,
    /// Recordings, which hear what happens elsewhere than on the bus.
    recordings: Arc<Mutex<Vec<Notes>>>,
}

struct Tap {
    senders: Vec<Sender<String>>,
    narrator: NoticeWriter,
}

impl Events {
    pub fn new() -> Self {
        let (lines, receiver) = channel();
        let sender = EventSender { lines, recordings: Arc::default() };
        Self { sender, receiver: Mutex::new(receiver), listeners: Vec::new() }
    }

    pub fn observer(&self) -> impl Observer + use<> {
        Tap { senders: self.senders(), narrator: NoticeWriter::default() }
    }

    /// As an observer, for what happened when a recording was made.
    pub fn teller(&self) -> impl FnMut(String) + Send + use<> {
        let senders = self.senders();
        move |text| tell(&senders, &text)
    }

    fn senders(&self) -> Vec<Sender<String>> {
        self.listeners.iter().chain([&self.sender.lines]).cloned().collect()
    }

    /// What happens on the bus from now on, for somebody else too: from observers that are made
    /// after this, and nothing that is said by [`say`](Self::say).
    #[cfg(feature = "web")]
    pub fn listen(&mut self) -> Receiver<String> {
        let (sender, receiver) = channel();
        self.listeners.push(sender);
        receiver
    }

    /// For others who have something to say.
    pub fn sender(&self) -> EventSender {
        self.sender.clone()
    }

    /// Adds a line for people. It is not recorded.
    #[cfg(feature = "web")]
    pub fn say(&self, line: impl Into<String>) {
        self.sender.say(line);
    }

    /// Something happened elsewhere than on the bus: people are told, and it is recorded.
    pub fn happened(&self, notice: Notice) {
        self.sender.happened(notice);
    }

    /// The next line that has not been shown.
    pub fn next(&self) -> Option<String> {
        self.receiver.lock().ok()?.try_recv().ok()
    }
}

impl EventSender {
    /// Adds a line for people. It is not recorded.
    pub fn say(&self, line: impl Into<String>) {
        // Nobody listening any more is the end of the run.
        let _ = self.lines.send(line.into());
    }

    /// As [`Events::happened`].
    pub fn happened(&self, notice: Notice) {
        self.say(notice.text.clone());
        self.note(&notice);
    }

    /// Records what people are told otherwise, or need not be told.
    pub fn note(&self, notice: &Notice) {
        let recordings = self.recordings.lock().unwrap_or_else(PoisonError::into_inner);
        recordings.iter().for_each(|recording| recording.add(notice.clone()));
    }

    /// Adds a recording that hears what happens.
    pub fn record(&self, recording: Notes) {
        self.recordings.lock().unwrap_or_else(PoisonError::into_inner).push(recording);
    }
}

impl Observer for Tap {
    fn row(&mut self, _: &Row<'_>) {}

    fn event(&mut self, event: &Event<'_>) {
        let Some(Notice { text, .. }) = self.narrator.notice(event) else { return };
        tell(&self.senders, &text);
    }
}

fn tell(senders: &[Sender<String>], text: &str) {
    for sender in senders {
        // Nobody listening any more is the end of the run.
        let _ = sender.send(text.to_owned());
    }
}
