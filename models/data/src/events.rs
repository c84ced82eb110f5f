//! What happened while a recording was made, as the recording itself says: comments of a table, log
//! messages of a bag.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use mcap::io::MessageReader;
use serde::{Deserialize, Serialize};

use super::bag::log_message;
use super::{DataError, source};

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// When, s, on the time axis of the recording.
    pub t_s: f64,
    /// What kind, in a word, such as `board_missing`.
    pub kind: String,
    /// In a sentence.
    #[serde(default)]
    pub text: String,
}

/// The events in the file at `path`, in its order; none in a file of another origin. Lines and
/// messages that cannot be understood are left out, as is the end of a file that is cut off.
///
/// # Errors
/// [`DataError`] when the file cannot be opened.
pub fn events(path: &Path) -> Result<Vec<Event>, DataError> {
    let open = source::open(path)?;
    Ok(if open.is_bag { of_bag(open.text) } else { of_table(open.text) })
}

fn of_table(text: impl Read) -> Vec<Event> {
    const KEY: &[u8] = b"# event: ";
    let mut events = Vec::new();
    let mut reader = BufReader::new(text);
    let mut line = Vec::new();
    // What comes after a defect of the file is not looked for: reading the rows says what is wrong.
    while reader.read_until(b'\n', &mut line).is_ok_and(|read| read > 0) {
        if let Some(value) = line.strip_prefix(KEY) {
            events.extend(serde_json::from_slice::<Event>(value).ok());
        }
        line.clear();
    }
    events
}

fn of_bag(content: impl Read) -> Vec<Event> {
    const SECOND_NS: f64 = 1e9;
    let (mut events, mut start_ns) = (Vec::new(), None);
    for message in MessageReader::new(content).map_while(Result::ok) {
        let topic = message.channel.topic.as_str();
        if topic.ends_with("/pressure_state") {
            start_ns = start_ns.or(Some(message.log_time));
        } else if topic.ends_with("/events")
            && let Some((kind, text)) = log_message(&message)
        {
            events.push((message.log_time, kind, text));
        }
    }
    let start_ns = start_ns.unwrap_or(0);
    let since = |ns: u64| if ns < start_ns { -((start_ns - ns) as f64) } else { (ns - start_ns) as f64 };
    let event = |(ns, kind, text)| Event { t_s: since(ns) / SECOND_NS, kind, text };
    events.into_iter().map(event).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_of_a_table_are_its_comments() {
        let text = "# program: \"x\"\nt_s,b0_p0_kpa\n# event: {\"t_s\":3.2,\"kind\":\"board_missing\",\"board\":1,\"text\":\"board 1 is missing\"}\n\
            0,1\n# event: {broken\n1,2\n# event: {\"t_s\":9.0,\"kind\":\"end\"}";
        let found = of_table(text.as_bytes());
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].t_s, found[0].kind.as_str()), (3.2, "board_missing"));
        assert_eq!((found[1].kind.as_str(), found[1].text.as_str()), ("end", ""));
    }
}
