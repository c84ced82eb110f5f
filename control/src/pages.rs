use crate::{BoardState, BusPort, ChannelStatus, ControlStatus, Micros, SensorFault};
use pneudrive_protocol::pages::{
    ChannelNow, Counter, Drives, Entry, NowState, PageEntry, StateNow, number_entry,
};

impl BusPort {
    /// The words of an entry at `now`; `None` before the first control step. What changes something
    /// is obeyed in a session.
    pub(crate) fn entry(&mut self, entry: PageEntry, now: Micros, in_session: bool) -> Option<Entry> {
        // Not copied: a board has 20 us for its answer.
        let control = self.control.as_ref()?;
        Some(match entry {
            PageEntry::State => state_of(control).to_entry(),
            PageEntry::Drives => Drives::new(control.drives.map(|drive| drive.get())).to_entry(),
            PageEntry::Counter(counter) => number_entry(self.counter(counter, control, now)),
            PageEntry::About => self.identity().about.to_entry(),
            PageEntry::Session(host) => self.offer_session(now, host).to_entry(),
            PageEntry::PostMortemWord(word) => {
                let word = self.identity().post_mortem.get(usize::from(word));
                number_entry(word.copied().unwrap_or(0))
            }
            PageEntry::Parameter(parameter) => self.desk().in_effect(parameter),
            PageEntry::Compiled(parameter) => self.desk().compiled(parameter),
            PageEntry::Store => self.desk().state().to_entry(),
            PageEntry::Change(change) => self.desk().change(change, in_session).to_entry(),
            PageEntry::LineRate => self.line_rate().state().to_entry(),
            PageEntry::SetLineRate(rate) => self.line_rate().change(rate, in_session).to_entry(),
            PageEntry::Sensor(entry) => self.sensors().entry(entry, now),
            PageEntry::Electronics => self.sensors().electronics(now).to_entry(),
            PageEntry::Program(entry) => self.update.entry(entry),
            PageEntry::Update(update) => self.update.update(update, in_session).to_entry(),
        })
    }

    fn counter(&self, counter: Counter, control: &ControlStatus, now: Micros) -> u32 {
        let micros = |time: Micros| u32::try_from(time.get()).unwrap_or(u32::MAX);
        match counter {
            Counter::Requests => self.requests(),
            Counter::Answers => self.answers(),
            Counter::PageRequests => self.page_requests(),
            Counter::LineErrors => self.line_errors(),
            Counter::Packets => self.frames().packets,
            Counter::DiscardedBytes => self.frames().discarded_bytes,
            Counter::Steps => control.steps,
            Counter::LateSteps => control.late_steps,
            Counter::LongestIntervalUs => micros(control.longest_interval),
            Counter::LongestLoopUs => micros(self.longest_loop()),
            Counter::CommandTimeouts => control.command_timeouts,
            Counter::SensorFaults => control.sensor_faults,
            Counter::UptimeS => u32::try_from(now.get() / 1_000_000).unwrap_or(u32::MAX),
            Counter::WatchdogResets => self.identity().watchdog_resets,
            Counter::DamagedRequests => self.damaged_requests(),
            Counter::UnverifiedPackets => self.frames().unverified,
        }
    }
}

fn state_of(control: &ControlStatus) -> NowState {
    let board = match control.state {
        BoardState::PowerUpVent => StateNow::PowerUpVent,
        BoardState::Running => StateNow::Running,
        BoardState::Hold => StateNow::Hold,
        BoardState::Vent => StateNow::Vent,
        BoardState::DamageVent => StateNow::DamageVent,
    };
    let channels = control.channels.map(|channel| match channel {
        ChannelStatus::Regulating => ChannelNow::Regulating,
        ChannelStatus::Venting => ChannelNow::Venting,
        ChannelStatus::SensorFault(SensorFault::BelowRange) => ChannelNow::SensorBelowRange,
        ChannelStatus::SensorFault(SensorFault::AboveRange) => ChannelNow::SensorAboveRange,
        ChannelStatus::Disabled => ChannelNow::Disabled,
    });
    NowState { board, channels }
}
