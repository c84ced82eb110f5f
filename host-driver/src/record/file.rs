use super::{Encoding, RecordError};
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file that only ever ends behind a whole block.
#[derive(Debug)]
pub(super) struct BlockFile {
    path: PathBuf,
    file: File,
    encoding: Encoding,
    length: u64,
}

impl BlockFile {
    /// How `path` will be written, if it can be.
    pub(super) fn check(path: &Path, overwrite: bool) -> Result<Encoding, RecordError> {
        if is_device(path) {
            // /dev/full and the like have no ending to go by, and exist on purpose.
            return Ok(Encoding::of(path).unwrap_or(Encoding::Plain));
        }
        let file = || path.to_owned();
        let encoding = Encoding::of(path).ok_or_else(|| RecordError::UnknownFormat { file: file() })?;
        if path.exists() && !overwrite {
            return Err(RecordError::Exists { file: file() });
        }
        match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
                Err(RecordError::NotCreated { file: file(), reason: "there is no such folder".into() })
            }
            _ => Ok(encoding),
        }
    }

    pub(super) fn create(path: &Path, overwrite: bool) -> Result<Self, RecordError> {
        let encoding = Self::check(path, overwrite)?;
        let mut options = OpenOptions::new();
        options.write(true);
        if overwrite {
            options.create(true).truncate(true);
        } else if !is_device(path) {
            options.create_new(true);
        }
        let file = options.open(path).map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => RecordError::Exists { file: path.to_owned() },
            _ => RecordError::NotCreated { file: path.to_owned(), reason: error.to_string() },
        })?;
        Ok(Self { path: path.to_owned(), file, encoding, length: 0 })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Appends a block of whole rows, or nothing.
    pub(super) fn append(&mut self, text: &[u8]) -> io::Result<()> {
        let block = self.encoding.block(text)?;
        if let Err(error) = self.file.write_all(&block) {
            // Devices cannot be cut; a file can.
            let _ = self.file.set_len(self.length);
            return Err(error);
        }
        self.length += block.len() as u64;
        Ok(())
    }

    /// Makes what has been appended survive a power failure.
    pub(super) fn sync(&self) -> io::Result<()> {
        match self.file.sync_data() {
            // Devices and pipes have nothing to sync.
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
            result => result,
        }
    }
}

/// Neither a file nor a folder.
fn is_device(path: &Path) -> bool {
    path.metadata().is_ok_and(|status| !status.is_file() && !status.is_dir())
}
