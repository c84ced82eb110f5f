//! Closes a bag whose recording was killed: what is whole in it, with the indexes and the metadata
//! that readers of ROS bags ask for.

mod metadata;

use self::metadata::{Topic, Topics};
use mcap::records::{MessageHeader, Record};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Repaired {
    /// The new file; metadata.yaml is beside it.
    pub file: PathBuf,
    /// Messages in it.
    pub messages: u64,
    /// From the first message to the last, s.
    pub seconds: f64,
    /// What the reader met where the old file stops; `None` if it had its end, so that nothing was
    /// wrong with it.
    pub stopped: Option<String>,
}

/// A bag that cannot be repaired.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RepairError {
    /// The bag cannot be read at all.
    #[error("{file}: {reason}")]
    Read {
        /// Which.
        file: String,
        /// Why not.
        reason: String,
    },
    /// There is nothing to save.
    #[error("{file}: not one message in it is whole: {reason}")]
    Empty {
        /// Which.
        file: String,
        /// What the reader met.
        reason: String,
    },
    /// The new bag cannot be written.
    #[error("{file}: cannot be written: {reason}")]
    Write {
        /// Which.
        file: String,
        /// Why not.
        reason: String,
    },
}

/// Longest record, bytes: what a damaged length can make the reader allocate.
const LONGEST_RECORD: usize = 1 << 30;

/// Writes the whole messages of the bag `from` into the new folder `folder`, under the same name,
/// and metadata.yaml beside them: the folder is a bag that `ros2 bag` opens. `from` stays as it is.
///
/// # Errors
/// [`RepairError`]. The folder must not exist: nothing is overwritten.
pub fn repair(from: &Path, folder: &Path) -> Result<Repaired, RepairError> {
    let shown = |path: &Path| path.display().to_string();
    let read = |error: io::Error| RepairError::Read { file: shown(from), reason: error.to_string() };
    let content = BufReader::new(File::open(from).map_err(read)?);
    let name = from.file_name().unwrap_or_default();
    let file = folder.join(name);
    let write = |reason: String| RepairError::Write { file: shown(&file), reason };
    std::fs::create_dir(folder)
        .map_err(|error| RepairError::Write { file: shown(folder), reason: error.to_string() })?;
    let new = File::create_new(&file).map_err(|error| write(error.to_string()))?;
    let copied = copy(content, BufWriter::new(new), &name.to_string_lossy());
    let result = match copied {
        Ok(Copy { topics, stopped }) if topics.messages() > 0 => {
            let yaml = topics.yaml(&name.to_string_lossy());
            let beside = std::fs::write(folder.join(metadata::FILE_NAME), yaml);
            beside.map_err(|error| write(error.to_string())).map(|()| Repaired {
                file: file.clone(),
                messages: topics.messages(),
                seconds: topics.seconds(),
                stopped,
            })
        }
        Ok(Copy { stopped, .. }) => Err(RepairError::Empty {
            file: shown(from),
            reason: stopped.unwrap_or_else(|| "it has none".into()),
        }),
        Err(Failed::Read(error)) => Err(RepairError::Read { file: shown(from), reason: error.to_string() }),
        Err(Failed::Write(error)) => Err(write(error.to_string())),
    };
    if result.is_err() {
        // Only what was made here; that it cannot be taken away again is no news beside the error.
        let _ = std::fs::remove_dir_all(folder);
    }
    result
}

struct Copy {
    topics: Topics,
    stopped: Option<String>,
}

enum Failed {
    Read(McapError),
    Write(McapError),
}

fn copy(content: impl Read, new: impl Write + Seek, name: &str) -> Result<Copy, Failed> {
    let options = WriteOptions::new()
        .profile("ros2")
        .library(concat!("pneudrive-model/", env!("CARGO_PKG_VERSION")))
        .compression_threads(0);
    let mut new = New {
        writer: Writer::with_options(new, options).map_err(Failed::Write)?,
        schemas: BTreeMap::new(),
        channels: BTreeMap::new(),
        topics: Topics::default(),
    };
    let stopped = match new.take_all(content) {
        Ok(true) => None,
        Ok(false) => Some("its end is missing".to_owned()),
        Err(Failed::Read(error)) if new.topics.messages() > 0 => Some(error.to_string()),
        Err(failed) => return Err(failed),
    };
    let record = metadata::record(new.topics.yaml(name));
    new.writer.write_metadata(&record).map_err(Failed::Write)?;
    new.writer.finish().map_err(Failed::Write)?;
    Ok(Copy { topics: new.topics, stopped })
}

/// The new file, and what numbers of the old one are called there.
struct New<W: Write + Seek> {
    writer: Writer<W>,
    schemas: BTreeMap<u16, (u16, String)>,
    channels: BTreeMap<u16, u16>,
    topics: Topics,
}

impl<W: Write + Seek> New<W> {
    /// Whether the old file has an end.
    fn take_all(&mut self, mut content: impl Read) -> Result<bool, Failed> {
        let options = LinearReaderOptions::default()
            .with_record_length_limit(LONGEST_RECORD)
            .with_validate_chunk_crcs(true);
        let mut reader = LinearReader::new_with_options(options);
        let mut has_end = false;
        while let Some(event) = reader.next_event() {
            match event.map_err(Failed::Read)? {
                LinearReadEvent::ReadRequest(wanted) => {
                    let read =
                        content.read(reader.insert(wanted)).map_err(|error| Failed::Read(error.into()))?;
                    reader.notify_read(read);
                }
                LinearReadEvent::Record { data, opcode } => {
                    let record = mcap::parse_record(opcode, data).map_err(Failed::Read)?;
                    has_end |= matches!(record, Record::Footer(_));
                    self.take(record).map_err(Failed::Write)?;
                }
            }
        }
        Ok(has_end)
    }

    fn take(&mut self, record: Record<'_>) -> McapResult<()> {
        match record {
            Record::Schema { header, data } => {
                let id = self.writer.add_schema(&header.name, &header.encoding, &data)?;
                self.schemas.insert(header.id, (id, header.name));
            }
            Record::Channel(channel) => {
                let (schema, ros_type) = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                let (topic, encoding) = (&channel.topic, &channel.message_encoding);
                let id = self.writer.add_channel(schema, topic, encoding, &channel.metadata)?;
                self.channels.insert(channel.id, id);
                self.topics.add(id, Topic::new(channel, ros_type));
            }
            Record::Message { header, data } => {
                // A message of a channel that was never told cannot be read by anybody.
                if let Some(&channel_id) = self.channels.get(&header.channel_id) {
                    self.writer.write_to_known_channel(&MessageHeader { channel_id, ..header }, &data)?;
                    self.topics.count(channel_id, header.log_time);
                }
            }
            Record::Metadata(metadata) if metadata.name != metadata::RECORD_NAME => {
                self.writer.write_metadata(&metadata)?;
            }
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mcap::MessageStream;
    use mcap::records::Metadata;

    const MESSAGES: u64 = 400;

    /// A bag of two topics in many chunks.
    fn bag() -> Vec<u8> {
        let mut bytes = io::Cursor::new(Vec::new());
        let options = WriteOptions::new().profile("ros2").chunk_size(Some(1 << 10)).compression_threads(0);
        let mut writer = Writer::with_options(&mut bytes, options).unwrap();
        let about = BTreeMap::from([("port".to_owned(), "\"sim\"".to_owned())]);
        writer.write_metadata(&Metadata { name: "pneudrive".to_owned(), metadata: about }).unwrap();
        let schema = writer.add_schema("sensor_msgs/msg/JointState", "ros2msg", b"float64[] effort").unwrap();
        let told = BTreeMap::from([("topic_type_hash".to_owned(), "RIHS01_a1".to_owned())]);
        let topics = ["/n/joint_0/pressure_state", "/n/joint_1/pressure_state"];
        let topics = topics.map(|topic| writer.add_channel(schema, topic, "cdr", &told).unwrap());
        for n in 0..MESSAGES {
            let channel_id = topics[n as usize % 2];
            let at_ns = 1_000_000_000 + n * 1_000_000;
            let header =
                MessageHeader { channel_id, sequence: n as u32, log_time: at_ns, publish_time: at_ns };
            // Not to be compressed to nothing.
            let data: Vec<u8> = (0..64).map(|byte: u64| (byte * n * 7919 % 251) as u8).collect();
            writer.write_to_known_channel(&header, &data).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        bytes.into_inner()
    }

    fn messages(bytes: &[u8]) -> Vec<(String, u64, Vec<u8>)> {
        let all = MessageStream::new(bytes).unwrap().map(|message| message.unwrap());
        all.map(|one| (one.channel.topic.clone(), one.log_time, one.data.into_owned())).collect()
    }

    fn repaired(bytes: &[u8]) -> (Result<Repaired, RepairError>, tempfile::TempDir) {
        let folder = tempfile::tempdir().unwrap();
        let from = folder.path().join("run.mcap");
        std::fs::write(&from, bytes).unwrap();
        (repair(&from, &folder.path().join("new")), folder)
    }

    #[test]
    fn what_was_whole_is_there_wherever_the_file_stops() {
        let whole = bag();
        let all = messages(&whole);
        let mut most = 0;
        for kept in (whole.len() / 3..whole.len()).step_by(997) {
            let (repaired, folder) = repaired(&whole[..kept]);
            let repaired = repaired.unwrap();
            assert!(repaired.stopped.is_some());
            let new = std::fs::read(folder.path().join("new/run.mcap")).unwrap();
            let found = messages(&new);
            assert!(found.len() as u64 == repaired.messages && found.len() >= most);
            assert_eq!(found, all[..found.len()]);
            most = found.len();
            // With its index.
            let summary = mcap::Summary::read(&new).unwrap().unwrap();
            assert_eq!(summary.stats.unwrap().message_count, repaired.messages);
        }
        assert_eq!(most as u64, MESSAGES, "where only the index is missing");
    }

    #[test]
    fn the_folder_is_a_bag() {
        let whole = bag();
        let (repaired, folder) = repaired(&whole[..whole.len() - 100]);
        let repaired = repaired.unwrap();
        assert_eq!((repaired.messages, repaired.seconds), (MESSAGES, 0.399));
        let yaml = std::fs::read_to_string(folder.path().join("new/metadata.yaml")).unwrap();
        for line in
            ["message_count: 400", "message_count: 200", "type_description_hash: RIHS01_a1", "'run.mcap'"]
        {
            assert!(yaml.contains(line), "{line}: {yaml}");
        }
        let new = std::fs::read(folder.path().join("new/run.mcap")).unwrap();
        let indexes = mcap::Summary::read(&new).unwrap().unwrap().metadata_indexes;
        let names: Vec<_> = indexes.iter().map(|index| index.name.as_str()).collect();
        assert_eq!(names, ["pneudrive", "rosbag2"]);
    }

    #[test]
    fn what_cannot_be_repaired_is_told_and_leaves_nothing_behind() {
        let whole = bag();
        for bytes in [&b"t_s,b0_p0_kpa\n0,1\n"[..], &whole[..200]] {
            let (refused, folder) = repaired(bytes);
            let refused = refused.unwrap_err().to_string();
            assert!(refused.contains("run.mcap: "), "{refused}");
            assert!(!folder.path().join("new").exists());
        }
        let (repaired, folder) = repaired(&whole);
        assert_eq!(repaired.unwrap().stopped, None, "it has its end");
        let again = repair(&folder.path().join("run.mcap"), &folder.path().join("new"));
        assert!(again.unwrap_err().to_string().contains("new: cannot be written"));
        assert!(folder.path().join("new/run.mcap").exists());
    }
}
