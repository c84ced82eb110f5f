//! What a recording says of itself: the copy of the rig file that it carries, when it was made.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::{DataError, source};

/// Longest record of a bag, bytes: what a damaged length can make the reader allocate.
const LONGEST_RECORD: usize = 1 << 30;

/// The text of the rig file that the recording at `path` was made with; `None` where it carries
/// none, or is a pipe, which can be read only once.
///
/// # Errors
/// [`DataError`] when the file cannot be opened.
pub fn rig_copy(path: &Path) -> Result<Option<String>, DataError> {
    entry(path, "rig")
}

/// When the recording at `path` was begun, as RFC 3339 in UTC; `None` where it does not say so, or
/// is a pipe.
///
/// # Errors
/// [`DataError`] when the file cannot be opened.
pub fn created_utc(path: &Path) -> Result<Option<String>, DataError> {
    entry(path, "created_utc")
}

fn entry(path: &Path, key: &str) -> Result<Option<String>, DataError> {
    if !path.is_file() {
        return Ok(None);
    }
    let open = source::open(path)?;
    Ok(if open.is_bag { of_bag(open.text, key) } else { of_table(open.text, key) })
}

/// A comment above the header: `# rig: ` and a JSON string.
fn of_table(text: impl Read, key: &str) -> Option<String> {
    let lines = BufReader::new(text).lines().map_while(Result::ok);
    let mut comments = lines.take_while(|line| line.starts_with('#'));
    comments.find_map(|line| {
        let value = line.strip_prefix("# ")?.strip_prefix(key)?.strip_prefix(": ")?;
        serde_json::from_str(value).ok()
    })
}

/// A key of the metadata record `pneudrive`, which stands before the first message.
fn of_bag(mut content: impl Read, key: &str) -> Option<String> {
    let options = LinearReaderOptions::default().with_record_length_limit(LONGEST_RECORD);
    let mut reader = LinearReader::new_with_options(options);
    while let Some(Ok(event)) = reader.next_event() {
        match event {
            LinearReadEvent::ReadRequest(wanted) => {
                let read = content.read(reader.insert(wanted)).ok()?;
                reader.notify_read(read);
            }
            LinearReadEvent::Record { data, opcode } => match mcap::parse_record(opcode, data).ok()? {
                Record::Metadata(metadata) if metadata.name == "pneudrive" => {
                    return serde_json::from_str(metadata.metadata.get(key)?).ok();
                }
                Record::Message { .. } => return None,
                _ => {}
            },
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    const RIG: &str = "[supply]\npressure_kpa = 550\n";

    #[test]
    fn a_table_has_it_above_its_header() {
        let text = format!("# program: \"x\"\n# rig: {}\nt_s,b0_p0_kpa\n0,1\n", serde_json::json!(RIG));
        assert_eq!(of_table(text.as_bytes(), "rig").as_deref(), Some(RIG));
        assert_eq!(of_table(text.as_bytes(), "program").as_deref(), Some("x"));
        assert_eq!(of_table(&b"# program: \"x\"\nt_s,b0_p0_kpa\n# rig: \"late\"\n"[..], "rig"), None);
        assert_eq!(of_table(&b"# rig: broken\nt_s\n"[..], "rig"), None);
    }

    #[test]
    fn a_bag_has_it_in_its_metadata() {
        let bag = |metadata: BTreeMap<String, String>| {
            let mut bytes = std::io::Cursor::new(Vec::new());
            let mut writer = mcap::Writer::new(&mut bytes).unwrap();
            writer.write_metadata(&mcap::records::Metadata { name: "pneudrive".into(), metadata }).unwrap();
            writer.finish().unwrap();
            drop(writer);
            bytes.into_inner()
        };
        let with = bag(BTreeMap::from([("rig".to_owned(), serde_json::json!(RIG).to_string())]));
        assert_eq!(of_bag(&with[..], "rig").as_deref(), Some(RIG));
        assert_eq!(of_bag(&bag(BTreeMap::new())[..], "rig"), None);
        assert_eq!(of_bag(&b"no bag"[..], "rig"), None);
    }
}
