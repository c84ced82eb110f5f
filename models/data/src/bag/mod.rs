//! MCAP files with ROS 2 messages, as `pneudrive-host --record`, the ROS node and `ros2 bag record`
//! write them, to raw columns.
//!
//! ```text
//! file -> mcap (messages of our topics) -> message (CDR to named values)
//!      -> align (one row a bus cycle) -> raw columns
//! ```
//!
//! A row is made of the `pressure_state` messages of one bus cycle; its time is the stamp of the
//! first. Where these do not say what was commanded (the original project's message type), it is
//! what `pressure_command` brought last before them. A file whose end is missing is read as far as
//! it goes.

mod align;
mod error;
mod message;
mod repair;
mod topic;

pub use error::BagError;
pub(super) use message::log_message;
pub use repair::{RepairError, Repaired, repair};

use std::collections::BTreeMap;
use std::io::Read;

use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;

use self::align::Bus;
use self::message::{Decoder, Value};
use self::topic::{Quantity, Topic};
use super::DataError;
use super::csv::{RawTable, ReadPlan};

/// First bytes of an MCAP file.
pub(super) const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Messages between two progress calls.
const PROGRESS_MESSAGES: usize = 1 << 14;
/// A chunk or message longer than the file is taken for damage, unless it is compressed and shorter
/// than the first of these; longer than the second always. Bytes: what a length that was damaged
/// can make the reader allocate.
const RECORD_LIMITS: [u64; 2] = [1 << 26, 1 << 30];

/// Boards that are asked in turn: by the node that publishes, and the bus it names.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct BusName {
    node: String,
    bus: String,
}

impl std::fmt::Display for BusName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.node, self.bus)
    }
}

/// Reads all of `content`, of which `size` bytes are stored (0 if that is not known).
pub(super) fn read(
    file: &str,
    size: u64,
    content: &mut dyn Read,
    plan: &mut ReadPlan<'_>,
) -> Result<RawTable, DataError> {
    let refuse = |source| DataError::Bag { file: file.to_owned(), source };
    let mut buses: BTreeMap<BusName, Bus> = BTreeMap::new();
    let mut commands: BTreeMap<(String, u8), Vec<align::Command>> = BTreeMap::new();
    let mut topics: BTreeMap<u16, Option<(Topic, Decoder)>> = BTreeMap::new();
    let mut seen = std::collections::BTreeSet::new();
    let [least, most] = RECORD_LIMITS;
    let limit = if size == 0 { most } else { size.clamp(least, most) };
    let limit = usize::try_from(limit).unwrap_or(usize::MAX);
    let options =
        LinearReaderOptions::default().with_record_length_limit(limit).with_validate_chunk_crcs(true);
    let mut unfinished = None;
    let mut count = 0;
    for message in MessageReader::new_with_options(content, options) {
        let message = match message {
            Ok(message) => message,
            Err(error) if count == 0 => return Err(refuse(BagError::Damaged { reason: error.to_string() })),
            Err(error) => {
                unfinished = Some(error.to_string());
                break;
            }
        };
        count += 1;
        if count % PROGRESS_MESSAGES == 0 {
            (plan.progress)(count);
        }
        let channel = &message.channel;
        let known = match topics.entry(channel.id) {
            std::collections::btree_map::Entry::Occupied(known) => known.into_mut(),
            std::collections::btree_map::Entry::Vacant(new) => {
                seen.insert(channel.topic.clone());
                let topic = Topic::parse(&channel.topic);
                let decoder = topic.as_ref().map(|_| Decoder::of(channel)).transpose();
                new.insert(topic.zip(decoder.map_err(refuse)?))
            }
        };
        let Some((topic, decoder)) = known else { continue };
        let decoded = decoder.decode(&message.data, topic).map_err(|reason| {
            refuse(BagError::Message { topic: channel.topic.clone(), message: count, reason })
        })?;
        match topic.quantity {
            Quantity::State => {
                let name = BusName { node: topic.node.clone(), bus: decoded.frame };
                let stamp_ns = decoded.stamp_ns.unwrap_or(message.log_time);
                let values = decoded.values;
                buses.entry(name).or_default().push(stamp_ns, message.log_time, topic.joint, values);
            }
            Quantity::Command => {
                let command = align::Command { log_ns: message.log_time, values: decoded.values };
                commands.entry((topic.node.clone(), topic.joint)).or_default().push(command);
            }
        }
    }
    let (name, mut bus) = choose(buses, plan, &seen).map_err(refuse)?;
    for ((node, joint), mut given) in commands {
        if node == name.node {
            given.sort_by_key(|command| command.log_ns);
            bus.complete(joint, &given);
        }
    }
    let mut table = bus.into_table(file, plan.channels)?;
    table.unfinished = unfinished;
    Ok(table)
}

/// The one bus that the wanted channels are on.
fn choose(
    mut buses: BTreeMap<BusName, Bus>,
    plan: &ReadPlan<'_>,
    seen: &std::collections::BTreeSet<String>,
) -> Result<(BusName, Bus), BagError> {
    if buses.is_empty() {
        return Err(BagError::NoStates { found: listed(seen.iter().cloned()) });
    }
    if let Some(wanted) = plan.channels {
        let with: Vec<_> = buses
            .iter()
            .filter(|(_, bus)| wanted.iter().any(|id| bus.joints().contains(&id.board)))
            .map(|(name, _)| name.clone())
            .collect();
        // None of them: the message about the channel that is not there is the better one.
        if !with.is_empty() {
            buses.retain(|name, _| with.contains(name));
        }
    }
    if buses.len() > 1 {
        let found = buses.iter().map(|(name, bus)| {
            let joints: Vec<_> = bus.joints().iter().map(u8::to_string).collect();
            format!("{name} (boards {})", joints.join(", "))
        });
        return Err(BagError::SeveralBuses { found: listed(found) });
    }
    buses.pop_first().ok_or_else(|| BagError::NoStates { found: String::new() })
}

fn listed(names: impl Iterator<Item = String>) -> String {
    const SHOWN: usize = 12;
    let names: Vec<_> = names.collect();
    let mut text = names[..names.len().min(SHOWN)].join(", ");
    if names.len() > SHOWN {
        text.push_str(&format!(" and {} more", names.len() - SHOWN));
    }
    if text.is_empty() { "no messages".to_owned() } else { text }
}
