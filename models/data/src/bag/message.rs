//! One message to named values.

use byteorder::{BigEndian, LittleEndian};
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::error::BagError;
use super::topic::{Quantity, Topic};
use crate::ChannelId;
use crate::column::ColumnKind;

/// One value of a message: the column it belongs into.
pub(super) type Value = (ColumnKind, f64);

/// What a message says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Decoded {
    /// ns since 1970; `None` if the sender left it out.
    pub(super) stamp_ns: Option<u64>,
    pub(super) frame: String,
    pub(super) values: Vec<Value>,
}

/// Understands the messages of one topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Decoder {
    /// `sensor_msgs/msg/JointState`: names beside values.
    Named,
    /// `{std_msgs/Header header, float64[] ..}`: pressures by their place.
    Plain,
}

#[derive(Deserialize)]
struct Time {
    sec: i32,
    nanosec: u32,
}

#[derive(Deserialize)]
struct Header {
    stamp: Time,
    frame_id: String,
}

#[derive(Deserialize)]
struct JointState {
    header: Header,
    name: Vec<String>,
    position: Vec<f64>,
    _velocity: Vec<f64>,
    effort: Vec<f64>,
}

#[derive(Deserialize)]
struct Pressures {
    header: Header,
    pressure: Vec<f64>,
}

/// `rcl_interfaces/msg/Log`
#[derive(Deserialize)]
struct Log {
    _stamp: Time,
    _level: u8,
    _name: String,
    msg: String,
    _file: String,
    function: String,
    _line: u32,
}

/// Kind and text of an event: the function and the words of a log message. `None` for anything
/// else.
pub(crate) fn log_message(message: &mcap::Message<'_>) -> Option<(String, String)> {
    let schema = message.channel.schema.as_ref()?;
    let is_log = matches!(schema.name.as_str(), "rcl_interfaces/msg/Log" | "rcl_interfaces/Log");
    let log: Log = is_log.then(|| cdr(&message.data).ok()).flatten()?;
    Some((log.function, log.msg))
}

impl Decoder {
    /// By the type that the file says the topic has.
    pub(super) fn of(channel: &mcap::Channel<'_>) -> Result<Self, BagError> {
        let schema = channel.schema.as_ref();
        let name = schema.map_or("", |schema| schema.name.as_str());
        let definition = schema.map(|schema| String::from_utf8_lossy(&schema.data)).unwrap_or_default();
        let cdr = channel.message_encoding == "cdr";
        match name {
            "sensor_msgs/msg/JointState" | "sensor_msgs/JointState" if cdr => Ok(Self::Named),
            _ if cdr && is_header_and_numbers(&definition) => Ok(Self::Plain),
            _ => Err(BagError::Type {
                topic: channel.topic.clone(),
                found: format!("{name} ({})", channel.message_encoding),
            }),
        }
    }

    /// Understands `data`, a serialised message on `topic`.
    pub(super) fn decode(self, data: &[u8], topic: &Topic) -> Result<Decoded, String> {
        let (header, names, values) = match self {
            Self::Named => {
                let message: JointState = cdr(data)?;
                let values = if message.effort.is_empty() { message.position } else { message.effort };
                (message.header, message.name, values)
            }
            Self::Plain => {
                let message: Pressures = cdr(data)?;
                (message.header, Vec::new(), message.pressure)
            }
        };
        if !names.is_empty() && names.len() != values.len() {
            return Err(format!("{} names for {} values", names.len(), values.len()));
        }
        let by_place = |(place, value): (usize, &f64)| {
            let id = ChannelId { board: topic.joint, channel: u8::try_from(place).ok()? };
            let kind = match topic.quantity {
                Quantity::State => ColumnKind::Pressure(id),
                Quantity::Command => ColumnKind::Command(id),
            };
            Some((kind, *value))
        };
        let by_name: Vec<Value> = names
            .iter()
            .zip(&values)
            .enumerate()
            .filter_map(|(place, (name, value))| {
                Some((
                    ColumnKind::parse(name).or_else(|| of_named_channel(name, place, topic.joint))?,
                    *value,
                ))
            })
            .collect();
        // Names that are not ours (a robot's joints, say) are no reason to do without the values.
        let values = if by_name.is_empty() {
            values.iter().enumerate().filter_map(by_place).collect()
        } else {
            by_name
        };
        let stamp = &header.stamp;
        let stamp_ns = u64::try_from(stamp.sec).unwrap_or(0) * 1_000_000_000 + u64::from(stamp.nanosec);
        Ok(Decoded { stamp_ns: (stamp_ns > 0).then_some(stamp_ns), frame: header.frame_id, values })
    }
}

/// What a state of the ROS node holds at `place` where the rig file names the channel: `left_p_kpa`
/// among the four pressures, `left_cmd_kpa` among the four commands behind them.
fn of_named_channel(name: &str, place: usize, board: u8) -> Option<ColumnKind> {
    const CHANNELS: usize = 4;
    let id = ChannelId { board, channel: u8::try_from(place % CHANNELS).ok()? };
    match place / CHANNELS {
        0 if name.ends_with("_p_kpa") => Some(ColumnKind::Pressure(id)),
        1 if name.ends_with("_cmd_kpa") => Some(ColumnKind::Command(id)),
        _ => None,
    }
}

/// CDR as in OMG DDSI-RTPS 2.5, 10.2: two bytes say which, two are options.
fn cdr<T: DeserializeOwned>(data: &[u8]) -> Result<T, String> {
    let (message, _) = match data {
        [0, 1, _, _, content @ ..] => cdr_encoding::from_bytes::<T, LittleEndian>(content),
        [0, 0, _, _, content @ ..] => cdr_encoding::from_bytes::<T, BigEndian>(content),
        _ => return Err("it is not plain CDR (XCDR version 1)".to_owned()),
    }
    .map_err(|error| error.to_string())?;
    Ok(message)
}

/// Whether a definition in the language of ROS messages has exactly these two fields, whatever
/// their names.
fn is_header_and_numbers(definition: &str) -> bool {
    let own = definition.split("\n===").next().unwrap_or_default();
    let lines = own.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
    let types: Vec<_> = lines.filter_map(|line| line.split_whitespace().next()).collect();
    matches!(types[..], ["std_msgs/Header" | "std_msgs/msg/Header" | "Header", "float64[]"])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_originals_type_is_known_by_its_fields() {
        let definition = "# kPa\nstd_msgs/Header header\n\nfloat64[] pressure # gauge\n================\nMSG: std_msgs/Header\n";
        assert!(is_header_and_numbers(definition));
        assert!(!is_header_and_numbers("float64[] pressure"));
        assert!(!is_header_and_numbers("std_msgs/Header header\nfloat64[] a\nfloat64[] b"));
    }

    #[test]
    fn a_state_with_the_names_of_a_rig_file_is_understood() {
        let id = ChannelId { board: 2, channel: 3 };
        assert_eq!(of_named_channel("front left_p_kpa", 3, 2), Some(ColumnKind::Pressure(id)));
        assert_eq!(of_named_channel("front left_cmd_kpa", 7, 2), Some(ColumnKind::Command(id)));
        assert_eq!(of_named_channel("elbow", 3, 2), None);
        assert_eq!(of_named_channel("front left_cmd_kpa", 3, 2), None);
    }

    #[test]
    fn what_is_no_cdr_is_refused() {
        let topic = Topic { node: "/n".into(), joint: 0, quantity: Quantity::State };
        assert!(Decoder::Plain.decode(&[0, 1, 0], &topic).is_err());
        assert!(Decoder::Plain.decode(&[0, 1, 0, 0, 9], &topic).is_err());
        // A sequence that says it has 2^32 - 1 elements.
        let endless = [&[0u8, 1, 0, 0][..], &[0; 8], &[1, 0, 0, 0, 0, 0, 0, 0], &[0xff; 4]].concat();
        assert!(Decoder::Plain.decode(&endless, &topic).is_err());
    }
}
