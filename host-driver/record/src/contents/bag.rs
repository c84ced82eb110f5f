use super::{Contents, ContentsEvent};
use crate::bag::METADATA;
use crate::messages::Log;
use byteorder::LittleEndian;
use mcap::McapResult;
use mcap::records::{MessageHeader, Record};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::BTreeMap;
use std::io::Read;

/// Longest record, bytes: what a damaged length can make the reader allocate.
const LONGEST_RECORD: usize = 1 << 30;

/// Which topics are what.
#[derive(Default)]
struct Topics {
    names: BTreeMap<u16, String>,
    /// The one whose messages are counted as rows.
    rows: Option<u16>,
    first_ns: Option<u64>,
}

/// Reads the metadata and events, and counts the states of the board that comes first.
pub(super) fn read(content: impl Read) -> Contents {
    let mut contents = Contents::default();
    if let Err(error) = records(content, &mut contents) {
        contents.unfinished = Some(error.to_string());
    }
    contents
}

fn records(mut content: impl Read, contents: &mut Contents) -> McapResult<()> {
    let options = LinearReaderOptions::default().with_record_length_limit(LONGEST_RECORD);
    let mut reader = LinearReader::new_with_options(options);
    let mut topics = Topics::default();
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(wanted) => {
                let read = content.read(reader.insert(wanted))?;
                reader.notify_read(read);
            }
            LinearReadEvent::Record { data, opcode } => match mcap::parse_record(opcode, data)? {
                Record::Metadata(metadata) if metadata.name == METADATA => {
                    for (key, value) in metadata.metadata {
                        if let Ok(value) = serde_json::from_str(&value) {
                            contents.description.insert(key, value);
                        }
                    }
                }
                Record::Channel(channel) => {
                    topics.names.insert(channel.id, channel.topic);
                }
                Record::Message { header, data } => message(&header, &data, &mut topics, contents),
                _ => {}
            },
        }
    }
    Ok(())
}

fn message(header: &MessageHeader, data: &[u8], topics: &mut Topics, contents: &mut Contents) {
    let Some(name) = topics.names.get(&header.channel_id) else { return };
    let first_ns = *topics.first_ns.get_or_insert(header.log_time);
    let t_s = header.log_time.saturating_sub(first_ns) as f64 * 1e-9;
    if name.ends_with("/pressure_state") && *topics.rows.get_or_insert(header.channel_id) == header.channel_id
    {
        contents.row_at(t_s);
    }
    if name.ends_with("/events")
        && let Some(content) = data.get(4..)
        && let Ok((log, _)) = cdr_encoding::from_bytes::<Log, LittleEndian>(content)
    {
        contents.events.push(ContentsEvent { t_s, kind: log.function, board: None, text: log.msg });
    }
}
