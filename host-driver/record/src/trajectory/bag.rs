//! Commands from a ROS 2 bag: our own recordings, and what `ros2 bag record` makes of the node's
//! topics.

use super::{Channel, ColumnName, Trajectory, TrajectoryError};
use crate::messages::JointState;
use byteorder::LittleEndian;
use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;
use pneudrive_host::Calibration;
use pneudrive_protocol::CHANNELS;
use std::collections::BTreeMap;
use std::io::Read;

/// Longest record, bytes: what a damaged length can make the reader allocate.
const LONGEST_RECORD: usize = 1 << 30;

/// Rows as they grow: a row holds until the next one, channel by channel.
#[derive(Default)]
struct Rows {
    times_ns: Vec<u64>,
    /// By board and channel. One that is not named yet is at 0 kPa.
    channels: BTreeMap<(usize, usize), Vec<f64>>,
}

impl Rows {
    /// Begins the row of `at_ns`, unless it is there.
    fn begin(&mut self, at_ns: u64) {
        if self.times_ns.last().is_none_or(|&last| at_ns > last) {
            self.times_ns.push(at_ns);
            for kpa in self.channels.values_mut() {
                kpa.push(kpa.last().copied().unwrap_or(0.0));
            }
        }
    }

    fn put(&mut self, key: (usize, usize), kpa: f64) {
        let rows = self.times_ns.len();
        let column = self.channels.entry(key).or_insert_with(|| vec![0.0; rows]);
        if let Some(last) = column.last_mut() {
            *last = kpa;
        }
    }
}

/// Reads `content` as far as it goes: the end of a bag that was killed is missing. Times count from
/// the first message that has a command or pressure.
pub(super) fn read(
    file: &str,
    content: impl Read,
    boards: usize,
    calibration: &Calibration,
) -> Result<Trajectory, TrajectoryError> {
    let refuse = |reason: String| TrajectoryError::Unreadable { file: file.to_owned(), reason };
    let options = LinearReaderOptions::default().with_record_length_limit(LONGEST_RECORD);
    let mut rows = Rows::default();
    let mut first_ns = None;
    for message in MessageReader::new_with_options(content, options) {
        let message = match message {
            Ok(message) => message,
            Err(error) if rows.times_ns.is_empty() => {
                return Err(refuse(format!("not readable as a bag: {error}")));
            }
            Err(error) => {
                log::warn!("{file}: read as far as it goes ({error})");
                break;
            }
        };
        let Some(state) = joint_state(&message) else { continue };
        let at_ns = message.log_time.saturating_sub(*first_ns.get_or_insert(message.log_time));
        for (name, &kpa) in state.name.iter().zip(&state.effort) {
            let (board, channel) = match ColumnName::of(name) {
                ColumnName::Command { board, channel } => (board, channel),
                ColumnName::Misspelt { meant } => {
                    let (file, column) = (file.to_owned(), name.clone());
                    return Err(TrajectoryError::UnknownCommand { file, row: None, column, meant });
                }
                // A bag also holds what other programs publish.
                ColumnName::Time | ColumnName::Recorded | ColumnName::Other => continue,
            };
            if board >= boards || channel >= CHANNELS {
                return Err(TrajectoryError::NoSuchChannel {
                    file: file.to_owned(),
                    row: None,
                    column: name.clone(),
                    boards,
                });
            }
            super::scale(calibration, board, channel).counts(kpa).map_err(|reason| {
                TrajectoryError::Pressure {
                    file: file.to_owned(),
                    row: rows.times_ns.len() as u64 + 1,
                    column: name.clone(),
                    reason,
                }
            })?;
            rows.begin(at_ns);
            rows.put((board, channel), kpa);
        }
    }
    if rows.times_ns.is_empty() {
        return Err(refuse(
            "no commands in it; expected messages of sensor_msgs/msg/JointState with names such as b0_cmd0_kpa"
                .to_owned(),
        ));
    }
    let channels = rows.channels.into_iter();
    Ok(Trajectory {
        times_ns: rows.times_ns,
        channels: channels.map(|((board, channel), kpa)| Channel { board, channel, kpa }).collect(),
        ignored: Vec::new(),
    })
}

/// The message, if it is one of ours: XCDR1, little endian.
pub(crate) fn joint_state(message: &mcap::Message<'_>) -> Option<JointState> {
    let name = message.channel.schema.as_ref()?.name.as_str();
    if name != JointState::ROS_TYPE || message.channel.message_encoding != "cdr" {
        return None;
    }
    let content = message.data.strip_prefix(&[0, 1])?.get(2..)?;
    let (mut state, _) = cdr_encoding::from_bytes::<JointState, LittleEndian>(content).ok()?;
    state.number_names(&message.channel.topic);
    Some(state)
}
