use super::{Contents, ContentsEvent};
use serde::Deserialize;
use std::io::{self, BufRead, BufReader, Read};

/// An event as it stands behind `# event: `.
#[derive(Deserialize)]
struct EventLine {
    t_s: f64,
    kind: String,
    board: Option<u8>,
    text: String,
}

/// Reads the comments, and counts the rows.
pub(super) fn read(text: impl Read) -> io::Result<Contents> {
    let mut contents = Contents::default();
    let mut time = None;
    for (row, line) in BufReader::new(text).lines().enumerate() {
        let line = match line {
            Ok(line) => line,
            // A compressed file that was cut off.
            Err(error) if row > 0 => {
                contents.unfinished = Some(error.to_string());
                break;
            }
            Err(error) => return Err(error),
        };
        if let Some(comment) = line.strip_prefix('#') {
            add(&mut contents, comment);
            continue;
        }
        let mut cells = line.split(',');
        match time {
            None => {
                let place = cells.position(|name| name.trim_start_matches('\u{feff}').trim() == "t_s");
                // Another table than a recording.
                let Some(place) = place else { break };
                time = Some(place);
            }
            Some(place) => {
                if let Some(t_s) = cells.nth(place).and_then(|cell| cell.trim().parse().ok()) {
                    contents.row_at(t_s);
                }
            }
        }
    }
    Ok(contents)
}

/// `key: value` with a value in JSON; comments of others are left alone.
fn add(contents: &mut Contents, comment: &str) {
    let Some((key, value)) = comment.trim_start().split_once(": ") else { return };
    if key == "event" {
        if let Ok(EventLine { t_s, kind, board, text }) = serde_json::from_str(value) {
            contents.events.push(ContentsEvent { t_s, kind, board, text });
        }
    } else if let Ok(value) = serde_json::from_str(value) {
        contents.description.insert(key.to_owned(), value);
    }
}
