use super::{FileFormat, RecordError};
use std::cell::Cell;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file that only ever ends behind a whole block.
#[derive(Debug)]
pub(super) struct BlockFile {
    path: PathBuf,
    file: File,
    format: FileFormat,
    length: u64,
    /// It has been said that a file beside it belongs to another.
    told: Cell<bool>,
}

impl BlockFile {
    /// How `path` will be written, if it can be.
    pub(super) fn check(path: &Path, overwrite: bool) -> Result<FileFormat, RecordError> {
        if is_device(path) {
            // /dev/full and the like have no ending to go by, and exist on purpose.
            return Ok(FileFormat::of(path).unwrap_or(FileFormat::Plain));
        }
        let file = || path.to_owned();
        let format = FileFormat::of(path).ok_or_else(|| RecordError::UnknownFormat { file: file() })?;
        if path.exists() && !overwrite {
            return Err(RecordError::Exists { file: file() });
        }
        match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
                Err(RecordError::NotCreated { file: file(), reason: "there is no such folder".into() })
            }
            _ => Ok(format),
        }
    }

    pub(super) fn create(path: &Path, overwrite: bool) -> Result<Self, RecordError> {
        let format = Self::check(path, overwrite)?;
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
        Ok(Self { path: path.to_owned(), file, format, length: 0, told: Cell::new(false) })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn format(&self) -> FileFormat {
        self.format
    }

    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Appends a block of whole rows, or nothing.
    pub(super) fn append(&mut self, block: &[u8]) -> io::Result<()> {
        if let Err(error) = self.file.write_all(block) {
            // Devices cannot be cut; a file can.
            let _ = self.file.set_len(self.length);
            return Err(error);
        }
        self.length += block.len() as u64;
        Ok(())
    }

    /// Writes another file into the same folder, unless there is one of that name that does not
    /// belong to this file.
    pub(super) fn write_beside(&self, name: &str, content: &str) -> io::Result<()> {
        let path = self.path.with_file_name(name);
        let own_name = self.path.file_name().unwrap_or_default().to_string_lossy();
        match std::fs::read_to_string(&path) {
            Ok(old) if !old.contains(&*own_name) => {
                // It is tried at the start and at the end.
                if !self.told.replace(true) {
                    log::warn!(
                        "{}: belongs to another recording and stays as it is; tools that want a folder for a bag need one recording a folder",
                        path.display()
                    );
                }
                Ok(())
            }
            _ if is_device(&self.path) => Ok(()),
            _ => std::fs::write(&path, content),
        }
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
