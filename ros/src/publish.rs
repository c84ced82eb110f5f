//! The thread that publishes the states of one bus.

use crate::pressure::{Part, PressureMessage};
use crate::tap::State;
use pneudrive_host::line::Clock;
use pneudrive_record::messages::Time;
use ros2_client::Publisher;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Receiver;

/// What has happened to the states of a bus.
#[derive(Debug, Default)]
pub struct PublishCounters {
    /// Handed to DDS.
    pub published: AtomicU64,
    /// Not taken by DDS: a subscriber that acknowledges nothing has filled its memory.
    pub refused: AtomicU64,
}

/// A topic of one board.
pub struct StateTopic<M: PressureMessage> {
    /// What it is about.
    pub part: Part,
    /// Where to.
    pub publisher: Publisher<M>,
    /// The message, to be filled in again and again.
    pub message: M,
}

/// Publishes until the bus thread has ended. `topics` has those of each board, in the poller's
/// order.
pub fn run<M: PressureMessage>(
    mut topics: Vec<Vec<StateTopic<M>>>,
    states: &Receiver<State>,
    counters: &Arc<PublishCounters>,
) {
    let mut clocks = Clocks::new();
    for state in states {
        let stamp = clocks.stamp(state.asked_ns);
        for topic in topics.get_mut(state.index).into_iter().flatten() {
            topic.message.fill_state(topic.part, stamp, state.measured, state.command);
            let counter = match topic.publisher.publish(topic.message.clone()) {
                Ok(()) => &counters.published,
                Err(_) => &counters.refused,
            };
            counter.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// From the line's clock, which never jumps, to the time of day, which may be set.
pub struct Clocks {
    unix_offset_ns: u64,
    checked_ns: u64,
}

impl Clocks {
    const CHECK_EVERY_NS: u64 = 1_000_000_000;
    /// Reading two clocks one after the other differs by less than this from one time to the next.
    const JUMP_NS: u64 = 1_000_000;

    /// As the clocks are now.
    pub fn new() -> Self {
        Self { unix_offset_ns: Clock.unix_offset_ns(), checked_ns: 0 }
    }

    /// The time of day at `at_ns` on the line's clock.
    pub fn stamp(&mut self, at_ns: u64) -> Time {
        if at_ns >= self.checked_ns + Self::CHECK_EVERY_NS {
            self.checked_ns = at_ns;
            let offset_ns = Clock.unix_offset_ns();
            if offset_ns.abs_diff(self.unix_offset_ns) > Self::JUMP_NS {
                log::warn!("the system's time was set; stamps follow");
                self.unix_offset_ns = offset_ns;
            }
        }
        Time::from_unix_ns(at_ns + self.unix_offset_ns)
    }
}
