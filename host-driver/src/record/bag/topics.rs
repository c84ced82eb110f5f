use crate::messages::JointState;
use crate::poller::BoardCommand;
use mcap::{McapResult, Writer};
use std::collections::BTreeMap;
use std::io::{Seek, Write};

/// A topic in the file.
pub(super) struct Channel {
    pub(super) id: u16,
    pub(super) topic: String,
    pub(super) count: u64,
    /// The message, to be filled in again and again.
    pub(super) message: JointState,
}

/// The topics of one board.
pub(super) struct BoardTopics {
    pub(super) state: Channel,
    pub(super) command: Channel,
    /// What was commanded last.
    pub(super) last_command: Option<BoardCommand>,
}

/// The quality of service at which a topic was offered. The same in the file and in metadata.yaml, or readers find nothing;
/// empty, because nothing was offered to anybody.
pub(super) const OFFERED_QOS: &str = "";

impl BoardTopics {
    pub(super) fn add<W: Write + Seek>(
        writer: &mut Writer<W>,
        prefix: &str,
        joint: u16,
        bus: usize,
    ) -> McapResult<Self> {
        let schema = writer.add_schema(JointState::ROS_TYPE, "ros2msg", JointState::DEFINITION.as_bytes())?;
        let metadata = BTreeMap::from([("offered_qos_profiles".to_owned(), OFFERED_QOS.to_owned())]);
        let mut channel = |name: &str, message| {
            let topic = format!("{prefix}/joint_{joint}/{name}");
            let id = writer.add_channel(schema, &topic, "cdr", &metadata)?;
            McapResult::Ok(Channel { id, topic, count: 0, message })
        };
        Ok(Self {
            state: channel("pressure_state", JointState::state(joint, bus))?,
            command: channel("pressure_command", JointState::command(joint, bus))?,
            last_command: None,
        })
    }
}
