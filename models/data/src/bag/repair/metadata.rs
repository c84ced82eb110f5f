//! metadata.yaml: what makes a folder with an MCAP file a ROS 2 bag. Version 8 of its format (ROS 2
//! Jazzy reads up to 9).

use mcap::records::{Channel, Metadata};
use std::collections::BTreeMap;
use std::fmt::Write;

pub(super) const FILE_NAME: &str = "metadata.yaml";

/// The record in the file that says the same.
pub(super) const RECORD_NAME: &str = "rosbag2";

/// A topic of the bag.
#[derive(Debug, Clone)]
pub(super) struct Topic {
    name: String,
    ros_type: String,
    encoding: String,
    qos: String,
    type_hash: String,
    messages: u64,
}

impl Topic {
    /// Of a channel whose messages are of this type.
    pub(super) fn new(channel: Channel, ros_type: String) -> Self {
        let mut told = channel.metadata;
        let mut take = |key: &str| told.remove(key).unwrap_or_default();
        let (qos, type_hash) = (take("offered_qos_profiles"), take("topic_type_hash"));
        Self {
            name: channel.topic,
            ros_type,
            encoding: channel.message_encoding,
            qos,
            type_hash,
            messages: 0,
        }
    }
}

/// All topics, and from when to when their messages are, ns since 1970.
#[derive(Debug, Default)]
pub(super) struct Topics {
    topics: BTreeMap<u16, Topic>,
    first_ns: u64,
    last_ns: u64,
}

impl Topics {
    pub(super) fn add(&mut self, id: u16, topic: Topic) {
        self.topics.entry(id).or_insert(topic);
    }

    pub(super) fn count(&mut self, id: u16, at_ns: u64) {
        self.first_ns = if self.messages() == 0 { at_ns } else { self.first_ns.min(at_ns) };
        self.last_ns = self.last_ns.max(at_ns);
        if let Some(topic) = self.topics.get_mut(&id) {
            topic.messages += 1;
        }
    }

    pub(super) fn messages(&self) -> u64 {
        self.topics.values().map(|topic| topic.messages).sum()
    }

    pub(super) fn seconds(&self) -> f64 {
        (self.last_ns - self.first_ns) as f64 * 1e-9
    }

    /// The content of metadata.yaml.
    pub(super) fn yaml(&self, file: &str) -> String {
        let (messages, first_ns) = (self.messages(), self.first_ns);
        let (duration_ns, file) = (self.last_ns - first_ns, quoted(file));
        let mut text = format!(
            "rosbag2_bagfile_information:
  version: 8
  storage_identifier: mcap
  duration:
    nanoseconds: {duration_ns}
  starting_time:
    nanoseconds_since_epoch: {first_ns}
  message_count: {messages}
  topics_with_message_count:
"
        );
        for topic in self.topics.values() {
            // Writing to a String does not fail.
            let _ = writeln!(
                text,
                "    - topic_metadata:
        name: {name}
        type: {ros_type}
        serialization_format: {encoding}
        offered_qos_profiles: {qos}
        type_description_hash: {type_hash}
      message_count: {count}",
                name = quoted(&topic.name),
                ros_type = topic.ros_type,
                encoding = topic.encoding,
                qos = quoted(&topic.qos),
                type_hash = if topic.type_hash.is_empty() { "''" } else { &topic.type_hash },
                count = topic.messages,
            );
        }
        let _ = writeln!(
            text,
            "  compression_format: ''
  compression_mode: ''
  relative_file_paths:
    - {file}
  files:
    - path: {file}
      starting_time:
        nanoseconds_since_epoch: {first_ns}
      duration:
        nanoseconds: {duration_ns}
      message_count: {messages}
  custom_data: ~
  ros_distro: ''"
        );
        text
    }
}

/// The same inside the file, where `ros2 bag` looks for it if metadata.yaml is missing.
pub(super) fn record(yaml: String) -> Metadata {
    let metadata =
        BTreeMap::from([("serialized_metadata".to_owned(), yaml), ("ROS_DISTRO".to_owned(), String::new())]);
    Metadata { name: RECORD_NAME.to_owned(), metadata }
}

/// A YAML string of any characters but line ends, of which quality of service as text has some.
fn quoted(text: &str) -> String {
    match text.contains(['\n', '\r']) {
        false => format!("'{}'", text.replace('\'', "''")),
        true => format!("{text:?}"),
    }
}
