/// What is wrong with a bag.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BagError {
    /// Not a single message can be read.
    #[error("no message can be read: {reason}; the file may be cut off or damaged, copy it again")]
    Damaged {
        /// What the reader said.
        reason: String,
    },
    /// No pressures.
    #[error(
        "no topic such as /pneudrive/joint_0/pressure_state among: {found}; record the topics of the ROS node, or convert to CSV"
    )]
    NoStates {
        /// The topics that are there.
        found: String,
    },
    /// Boards that are not asked in turn have no common rows.
    #[error(
        "several buses, which are not in step: {found}; choose channels of one of them (--channels b0c0,b0c1, in Python channels=), or record with --first-joint so that board numbers differ"
    )]
    SeveralBuses {
        /// Node, bus and boards of each.
        found: String,
    },
    /// A topic of ours with a type of somebody else's.
    #[error(
        "{topic} has the type {found}; expected sensor_msgs/msg/JointState, or a message of a std_msgs/Header and a float64[], as CDR"
    )]
    Type {
        /// The topic.
        topic: String,
        /// Its type and encoding.
        found: String,
    },
    /// A message that is not of the type that the file says.
    #[error("message {message}, on {topic}: {reason}")]
    Message {
        /// The topic.
        topic: String,
        /// Its number in the file, from 1.
        message: usize,
        /// What is wrong with it.
        reason: String,
    },
}
