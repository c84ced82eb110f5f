//! What a recording's file looks like, by its name; and what turns rows into it.

use super::Description;
use super::rows::{Batch, Formatter, RecordedEvent, comment_line, event_line};
use std::io::{self, Write};
use std::path::Path;
use std::time::{Duration, SystemTime};

/// By the name's ending.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileFormat {
    /// `.csv`
    Plain,
    /// `.csv.gz`: each block is a gzip member (RFC 1952, 2.2: members simply follow each other).
    Gzip,
    /// `.csv.zst`: each block is a zstd frame (RFC 8878, 3: frames simply follow each other).
    Zstd,
    /// `.mcap`: a ROS 2 bag; each block is a chunk with its indexes.
    Mcap,
}

impl FileFormat {
    const ENDINGS: &[(&str, Self)] =
        &[(".csv", Self::Plain), (".csv.gz", Self::Gzip), (".csv.zst", Self::Zstd), (".mcap", Self::Mcap)];

    /// The format that the name asks for.
    pub fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?.to_ascii_lowercase();
        Self::ENDINGS.iter().find_map(|(ending, format)| name.ends_with(ending).then_some(*format))
    }
}

/// Turns rows into blocks of bytes. Blocks can be put one behind the other, and each can be read
/// without those behind it.
pub(super) trait Form: Send {
    /// Takes rows and what happened between them.
    fn add(&mut self, batch: &Batch) -> io::Result<()>;

    /// Takes something that happened, from elsewhere than a bus.
    fn happened(&mut self, event: &RecordedEvent) -> io::Result<()>;

    /// Roughly how many bytes the next block has so far.
    fn waiting(&self) -> usize;

    /// What has been taken since the last block; at first with what comes before the first row.
    fn block(&mut self) -> io::Result<Vec<u8>>;

    /// The last block, with what ends a file.
    fn end(&mut self) -> io::Result<Vec<u8>>;

    /// Name and content, so far, of a file that belongs beside this one.
    fn companion(&self) -> Option<(&'static str, String)> {
        None
    }
}

/// CSV, each block compressed for itself if at all.
pub(super) struct Text {
    format: FileFormat,
    formatter: Formatter,
    /// What makes ns since 1970 of the times of the line.
    unix_offset_ns: u64,
    /// Whether it is said when on the calendar the times begin.
    dated: bool,
    text: Vec<u8>,
}

impl Text {
    pub(super) fn new(
        format: FileFormat,
        formatter: Formatter,
        description: &Description,
        unix_offset_ns: u64,
    ) -> Self {
        let mut text = Vec::new();
        description.entries().for_each(|(key, value)| comment_line(key, value, &mut text));
        text.extend(formatter.header());
        Self { format, formatter, unix_offset_ns, dated: false, text }
    }
}

impl Form for Text {
    fn add(&mut self, batch: &Batch) -> io::Result<()> {
        if !self.dated
            && let Some(start_ns) = batch.run_start_ns()
        {
            self.dated = true;
            let unix = Duration::from_nanos(start_ns.saturating_add(self.unix_offset_ns));
            let utc = humantime::format_rfc3339_nanos(SystemTime::UNIX_EPOCH + unix);
            comment_line("t0_utc", &format!("\"{utc}\""), &mut self.text);
        }
        self.formatter.append(batch, &mut self.text);
        Ok(())
    }

    fn happened(&mut self, event: &RecordedEvent) -> io::Result<()> {
        event_line(event, &mut self.text);
        Ok(())
    }

    fn waiting(&self) -> usize {
        self.text.len()
    }

    fn block(&mut self) -> io::Result<Vec<u8>> {
        if self.text.is_empty() {
            return Ok(Vec::new());
        }
        let block = compressed(self.format, &self.text)?;
        self.text.clear();
        Ok(block)
    }

    fn end(&mut self) -> io::Result<Vec<u8>> {
        self.block()
    }
}

/// `text` as it is stored.
fn compressed(format: FileFormat, text: &[u8]) -> io::Result<Vec<u8>> {
    match format {
        FileFormat::Gzip => {
            let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
            encoder.write_all(text)?;
            encoder.finish()
        }
        FileFormat::Zstd => zstd::bulk::compress(text, zstd::DEFAULT_COMPRESSION_LEVEL),
        _ => Ok(text.to_vec()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn blocks_follow_each_other() {
        for format in [FileFormat::Plain, FileFormat::Gzip, FileFormat::Zstd] {
            let stored =
                [compressed(format, b"one\n").unwrap(), compressed(format, b"two\n").unwrap()].concat();
            let mut text = String::new();
            match format {
                FileFormat::Gzip => {
                    flate2::read::MultiGzDecoder::new(&stored[..])
                        .read_to_string(&mut text)
                        .map(drop)
                        .unwrap();
                }
                FileFormat::Zstd => text = String::from_utf8(zstd::decode_all(&stored[..]).unwrap()).unwrap(),
                _ => text = String::from_utf8(stored).unwrap(),
            }
            assert_eq!(text, "one\ntwo\n", "{format:?}");
        }
    }

    #[test]
    fn the_name_decides() {
        let of = |name: &str| FileFormat::of(Path::new(name));
        assert_eq!(of("/a.b/run.csv"), Some(FileFormat::Plain));
        assert_eq!(of("run.CSV.GZ"), Some(FileFormat::Gzip));
        assert_eq!(of("run.csv.zst"), Some(FileFormat::Zstd));
        assert_eq!(of("run.mcap"), Some(FileFormat::Mcap));
        assert_eq!(of("run.txt"), None);
        assert_eq!(of("run.gz"), None);
    }
}
