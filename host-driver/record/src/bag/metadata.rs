//! metadata.yaml: what makes a folder with an MCAP file a ROS 2 bag. Version 8 of its format (ROS 2
//! Jazzy reads up to 9).

use super::topics::{OFFERED_QOS, Topic};
use crate::Description;
use mcap::records::Metadata;
use std::collections::BTreeMap;
use std::fmt::Write;

pub(super) const FILE_NAME: &str = "metadata.yaml";

/// Name of the record in which a recording says what it is.
pub(crate) const DESCRIPTION: &str = "pneudrive";

/// First and last time of messages, ns since 1970, and their number.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Extent {
    messages: u64,
    first_ns: u64,
    last_ns: u64,
}

impl Extent {
    pub(super) fn add(&mut self, at_ns: u64) {
        self.first_ns = if self.messages == 0 { at_ns } else { self.first_ns.min(at_ns) };
        self.last_ns = self.last_ns.max(at_ns);
        self.messages += 1;
    }
}

/// The content of metadata.yaml.
pub(super) fn yaml<'a>(file: &str, extent: &Extent, topics: impl Iterator<Item = &'a Topic>) -> String {
    let Extent { messages, first_ns, last_ns } = *extent;
    let (duration_ns, file) = (last_ns - first_ns, quoted(file));
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
    for Topic { name, ros_type, type_hash, count, .. } in topics {
        // Writing to a String does not fail.
        let _ = writeln!(
            text,
            "    - topic_metadata:
        name: {name}
        type: {ros_type}
        serialization_format: cdr
        offered_qos_profiles: '{OFFERED_QOS}'
        type_description_hash: {type_hash}
      message_count: {count}",
            name = quoted(name)
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

/// The same inside the file, where `ros2 bag` looks for it if metadata.yaml is missing.
pub(super) fn record(yaml: String) -> Metadata {
    let metadata =
        BTreeMap::from([("serialized_metadata".to_owned(), yaml), ("ROS_DISTRO".to_owned(), String::new())]);
    Metadata { name: "rosbag2".to_owned(), metadata }
}

/// What the recording says of itself: key by key, the values as JSON.
pub(super) fn description(description: &Description) -> Metadata {
    let entries = description.entries().map(|(key, value)| (key.to_owned(), value.to_owned()));
    Metadata { name: DESCRIPTION.to_owned(), metadata: entries.collect() }
}

/// A YAML string of any characters.
fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', "''"))
}
