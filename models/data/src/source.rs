//! Opening a file: what it is by its first bytes, its SHA-256, and how far reading has come.

use std::cell::RefCell;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;
use std::rc::Rc;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::DataError;

/// Where data came from: enough to find the file again and to know that it is the same.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Source {
    /// The file as given.
    pub file: String,
    /// SHA-256 of the file's bytes as stored (compressed if it is), hexadecimal: what `sha256sum`
    /// prints.
    pub sha256: String,
    /// Size of the file, bytes.
    pub bytes: u64,
}

/// Counts and hashes what passes through it.
struct Tap {
    inner: Box<dyn Read>,
    state: Rc<RefCell<TapState>>,
}

#[derive(Default)]
struct TapState {
    hash: Sha256,
    bytes: u64,
}

impl Read for Tap {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        let mut state = self.state.borrow_mut();
        state.hash.update(&buffer[..n]);
        state.bytes += n as u64;
        Ok(n)
    }
}

/// An open data file: decompressed text, and the tap on the stored bytes.
pub(crate) struct OpenFile {
    /// The file as given.
    pub file: String,
    /// Size on disk, bytes; 0 if unknown (a pipe).
    pub size: u64,
    /// Whether it is an MCAP file.
    pub is_bag: bool,
    /// Decompressed content.
    pub text: Box<dyn Read>,
    tap: Rc<RefCell<TapState>>,
}

const GZIP: &[u8] = &[0x1f, 0x8b];
const ZSTD: &[u8] = &[0x28, 0xb5, 0x2f, 0xfd];

/// Formats that people hand over in error, by their first bytes.
const UNSUPPORTED: [(&[u8], &str, &str); 6] = [
    (b"\xfd7zXZ\0", "an xz archive", "decompress it, or compress with gzip or zstd"),
    (b"BZh", "a bzip2 archive", "decompress it, or compress with gzip or zstd"),
    (b"PK\x03\x04", "a zip archive or a spreadsheet", "export it as CSV"),
    (
        b"SQLite format 3\0",
        "an SQLite database (a ROS bag?)",
        "convert it to MCAP with `ros2 bag convert`, or export it as CSV",
    ),
    (b"\x89HDF", "an HDF5 file", "export it as CSV"),
    (b"PAR1", "a Parquet file", "export it as CSV"),
];

/// Opens `path` and recognises what it holds by content, whatever its extension.
pub(crate) fn open(path: &Path) -> Result<OpenFile, DataError> {
    let file = path.display().to_string();
    let failed = |source| DataError::Open { file: file.clone(), source };
    let handle = File::open(path).map_err(failed)?;
    let metadata = handle.metadata().map_err(failed)?;
    if metadata.is_dir() {
        return Err(failed(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder; name a file in it")));
    }
    decode(file, metadata.len(), Box::new(handle))
}

/// Recognises what `handle` holds by its first bytes; `size` is 0 if unknown.
pub(crate) fn decode(file: String, size: u64, handle: Box<dyn Read>) -> Result<OpenFile, DataError> {
    let failed = |source| DataError::Open { file: file.clone(), source };
    let tap = Rc::new(RefCell::new(TapState::default()));
    let mut stored = BufReader::with_capacity(1 << 16, Tap { inner: handle, state: Rc::clone(&tap) });
    let head = stored.fill_buf().map_err(failed)?;
    if head.is_empty() {
        return Err(DataError::Empty { file });
    }
    if let Some(&(_, what, advice)) = UNSUPPORTED.iter().find(|(magic, _, _)| head.starts_with(magic)) {
        return Err(DataError::Unsupported { file, what, advice });
    }
    let is_bag = head.starts_with(super::bag::MAGIC);
    // Plain text under any name is read; what is neither is not what its name says.
    let promises = [(".gz", "gzip"), (".zst", "Zstandard"), (".mcap", "MCAP")];
    let recognised = is_bag || head.starts_with(GZIP) || head.starts_with(ZSTD);
    if let Some(&(_, what)) = promises.iter().find(|(ending, _)| file.ends_with(ending))
        && !recognised
        && std::str::from_utf8(head).is_err_and(|error| error.error_len().is_some())
    {
        return Err(DataError::NotAsNamed { file, what });
    }
    let text: Box<dyn Read> = if head.starts_with(GZIP) {
        Box::new(flate2::bufread::MultiGzDecoder::new(stored))
    } else if head.starts_with(ZSTD) {
        Box::new(zstd::stream::read::Decoder::with_buffer(stored).map_err(failed)?)
    } else {
        Box::new(stored)
    };
    Ok(OpenFile { file, size, is_bag, text, tap })
}

/// Tells how far the reading of a file has come while someone else reads it.
pub(crate) struct Meter(Rc<RefCell<TapState>>);

impl Meter {
    /// Stored bytes read so far.
    pub(crate) fn bytes(&self) -> u64 {
        self.0.borrow().bytes
    }
}

impl OpenFile {
    /// A meter of the stored bytes.
    pub(crate) fn meter(&self) -> Meter {
        Meter(Rc::clone(&self.tap))
    }

    /// Reads whatever is left and returns where the data came from.
    pub(crate) fn finish(mut self) -> Result<Source, DataError> {
        io::copy(&mut self.text, &mut io::sink()).map_err(|source| DataError::Read {
            file: self.file.clone(),
            line: 0,
            source,
        })?;
        let state = self.tap.borrow();
        let sha256 = hex(&state.hash.clone().finalize());
        Ok(Source { file: self.file, sha256, bytes: state.bytes })
    }
}

/// The source of a file's content that is in memory.
pub(crate) fn of_bytes(file: &str, bytes: &[u8]) -> Source {
    Source { file: file.to_owned(), sha256: hex(&Sha256::digest(bytes)), bytes: bytes.len() as u64 }
}

fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write as _;
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}
