//! How a block of rows is stored. Blocks can be put one behind the other, and each can be read without those behind it.

use std::io::{self, Write};
use std::path::Path;

/// Plain or compressed, by the name's ending.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// `.csv`
    Plain,
    /// `.csv.gz`: each block is a gzip member (RFC 1952, 2.2: members simply follow each other).
    Gzip,
    /// `.csv.zst`: each block is a zstd frame (RFC 8878, 3: frames simply follow each other).
    Zstd,
}

impl Encoding {
    /// The encoding that the name asks for.
    pub fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?.to_ascii_lowercase();
        [(".csv", Self::Plain), (".csv.gz", Self::Gzip), (".csv.zst", Self::Zstd)]
            .into_iter()
            .find_map(|(ending, encoding)| name.ends_with(ending).then_some(encoding))
    }

    /// `text` as it is stored.
    pub(super) fn block(self, text: &[u8]) -> io::Result<Vec<u8>> {
        match self {
            Self::Plain => Ok(text.to_vec()),
            Self::Gzip => {
                let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
                encoder.write_all(text)?;
                encoder.finish()
            }
            Self::Zstd => zstd::bulk::compress(text, zstd::DEFAULT_COMPRESSION_LEVEL),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn blocks_follow_each_other() {
        for encoding in [Encoding::Plain, Encoding::Gzip, Encoding::Zstd] {
            let stored = [encoding.block(b"one\n").unwrap(), encoding.block(b"two\n").unwrap()].concat();
            let mut text = String::new();
            match encoding {
                Encoding::Plain => text = String::from_utf8(stored).unwrap(),
                Encoding::Gzip => {
                    flate2::read::MultiGzDecoder::new(&stored[..])
                        .read_to_string(&mut text)
                        .map(drop)
                        .unwrap();
                }
                Encoding::Zstd => text = String::from_utf8(zstd::decode_all(&stored[..]).unwrap()).unwrap(),
            }
            assert_eq!(text, "one\ntwo\n", "{encoding:?}");
        }
    }

    #[test]
    fn the_name_decides() {
        let of = |name: &str| Encoding::of(Path::new(name));
        assert_eq!(of("/a.b/run.csv"), Some(Encoding::Plain));
        assert_eq!(of("run.CSV.GZ"), Some(Encoding::Gzip));
        assert_eq!(of("run.csv.zst"), Some(Encoding::Zstd));
        assert_eq!(of("run.txt"), None);
        assert_eq!(of("run.gz"), None);
    }
}
