//! Files as they are stored: plain, compressed, or bags, told apart by their first bytes.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// An open file.
pub(crate) enum Stored {
    /// Text, decompressed.
    Text(Box<dyn Read>),
    /// MCAP.
    Bag(Box<dyn Read>),
}

const GZIP: &[u8] = &[0x1f, 0x8b];
const ZSTD: &[u8] = &[0x28, 0xb5, 0x2f, 0xfd];
const MCAP: &[u8] = b"\x89MCAP0\r\n";

impl Stored {
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let opened = File::open(path).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => {
                io::Error::new(error.kind(), "cannot be opened: there is no such file")
            }
            _ => error,
        });
        let mut stored = BufReader::new(opened?);
        let head = stored.fill_buf()?;
        let (gzip, zstd, bag) = (head.starts_with(GZIP), head.starts_with(ZSTD), head.starts_with(MCAP));
        // A plain table may have any name; what is no text either was to be something else.
        let no_text = std::str::from_utf8(head).is_err_and(|error| error.error_len().is_some());
        if !(gzip || zstd || bag)
            && no_text
            && let Some(ending) = path.extension().and_then(|ending| ending.to_str())
            && ["gz", "zst", "mcap"].contains(&ending)
        {
            let text = format!("the file is damaged at its beginning, or is no .{ending} as its name says");
            return Err(io::Error::new(io::ErrorKind::InvalidData, text));
        }
        Ok(if bag {
            Self::Bag(Box::new(stored))
        } else if gzip {
            Self::Text(Box::new(flate2::bufread::MultiGzDecoder::new(stored)))
        } else if zstd {
            Self::Text(Box::new(zstd::stream::read::Decoder::with_buffer(stored)?))
        } else {
            Self::Text(Box::new(stored))
        })
    }
}
