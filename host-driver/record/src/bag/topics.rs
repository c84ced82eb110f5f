use crate::messages::{FluidPressure, Imu, JointState, Log};
use crate::{Description, PageColumns};
use mcap::{McapResult, Writer};
use pneudrive_host::poller::BoardCommand;
use std::collections::BTreeMap;
use std::io::{Seek, Write};

/// A topic in the file, and what is serialised into it.
pub(super) struct Channel<M> {
    pub(super) topic: Topic,
    /// The message, to be filled in again and again.
    pub(super) message: M,
}

/// A topic in the file.
pub(super) struct Topic {
    pub(super) id: u16,
    pub(super) name: String,
    pub(super) ros_type: &'static str,
    /// See [`JointState::ROS_TYPE_HASH`].
    pub(super) type_hash: &'static str,
    /// Messages so far.
    pub(super) count: u64,
}

/// What people call a board and its channels, from the entry `names` of a recording: metadata
/// `name` and `channel_0_name` and so on of its topics.
pub(super) fn names(description: &Description, board: u8) -> BTreeMap<String, String> {
    let entry = description.entries().find(|(key, _)| *key == "names").map_or("{}", |(_, json)| json);
    let mut all: BTreeMap<u8, BTreeMap<String, String>> = serde_json::from_str(entry).unwrap_or_default();
    let own = all.remove(&board).unwrap_or_default().into_iter();
    let key = |of: String| if of == "board" { "name".to_owned() } else { format!("channel_{of}_name") };
    own.map(|(of, name)| (key(of), name)).collect()
}

/// The topics of one board.
pub(super) struct BoardTopics {
    pub(super) state: Channel<JointState>,
    pub(super) command: Channel<JointState>,
    /// What was commanded last.
    pub(super) last_command: Option<BoardCommand>,
    /// Where sensors are recorded.
    pub(super) supply: Option<Channel<FluidPressure>>,
    pub(super) imu: Option<Channel<Imu>>,
}

/// The quality of service at which a topic was offered. The same in the file and in metadata.yaml,
/// or readers find nothing; empty, because nothing was offered to anybody.
pub(super) const OFFERED_QOS: &str = "";

impl<M> Channel<M> {
    fn add<W: Write + Seek>(
        writer: &mut Writer<W>,
        (ros_type, definition, type_hash): (&'static str, &str, &'static str),
        name: String,
        message: M,
        names: &BTreeMap<String, String>,
    ) -> McapResult<Self> {
        // A schema that is there already is not written again.
        let schema = writer.add_schema(ros_type, "ros2msg", definition.as_bytes())?;
        let mut metadata = names.clone();
        // As `ros2 bag record` writes them.
        metadata.insert("offered_qos_profiles".to_owned(), OFFERED_QOS.to_owned());
        metadata.insert("topic_type_hash".to_owned(), type_hash.to_owned());
        let id = writer.add_channel(schema, &name, "cdr", &metadata)?;
        Ok(Self { topic: Topic { id, name, ros_type, type_hash, count: 0 }, message })
    }
}

impl BoardTopics {
    pub(super) fn add<W: Write + Seek>(
        writer: &mut Writer<W>,
        prefix: &str,
        joint: u16,
        bus: usize,
        names: &BTreeMap<String, String>,
        pages: PageColumns,
    ) -> McapResult<Self> {
        let state = JointState::state_with(joint, bus, pages.drives, pages.sensors);
        let topic = |name: &str| format!("{prefix}/joint_{joint}/{name}");
        let mut channel = |name: &str, message| {
            let ros_type = (JointState::ROS_TYPE, JointState::DEFINITION, JointState::ROS_TYPE_HASH);
            Channel::add(writer, ros_type, topic(name), message, names)
        };
        let (state, command) = (
            channel("pressure_state", state)?,
            channel("pressure_command", JointState::command(joint, bus))?,
        );
        let (mut supply, mut imu) = (None, None);
        if pages.sensors {
            let ros_type = (FluidPressure::ROS_TYPE, FluidPressure::DEFINITION, FluidPressure::ROS_TYPE_HASH);
            let message = FluidPressure::of_joint(joint);
            supply = Some(Channel::add(writer, ros_type, topic("supply_pressure"), message, names)?);
            let ros_type = (Imu::ROS_TYPE, Imu::DEFINITION, Imu::ROS_TYPE_HASH);
            let message = Imu::of_joint(joint);
            imu = Some(Channel::add(writer, ros_type, topic("imu"), message, names)?);
        }
        Ok(Self { state, command, last_command: None, supply, imu })
    }

    /// All of them.
    pub(super) fn all(&self) -> impl Iterator<Item = &Topic> {
        let supply = self.supply.as_ref().map(|channel| &channel.topic);
        let imu = self.imu.as_ref().map(|channel| &channel.topic);
        [&self.state.topic, &self.command.topic].into_iter().chain(supply).chain(imu)
    }
}

/// The topic of what happens.
pub(super) fn add_events<W: Write + Seek>(writer: &mut Writer<W>, prefix: &str) -> McapResult<Channel<Log>> {
    let message = Log { name: prefix.trim_start_matches('/').replace('/', "."), ..Log::default() };
    Channel::add(
        writer,
        (Log::ROS_TYPE, Log::DEFINITION, Log::ROS_TYPE_HASH),
        format!("{prefix}/events"),
        message,
        &BTreeMap::new(),
    )
}
