//! Whether something can be written, found out while nothing has been done that would be lost.

use std::fs::{File, OpenOptions, remove_file};
use std::io;
use std::path::Path;

/// Whether the file at `path` can be made, or written if it is there. It is left as it is.
///
/// # Errors
/// What the system says.
pub fn file_is_writable(path: &Path) -> io::Result<()> {
    if path.exists() {
        return OpenOptions::new().write(true).open(path).map(drop);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder_is_writable(folder.unwrap_or(Path::new(".")))
}

/// Whether files can be made in `folder`. It is tried: modes are not all that forbids it, and do
/// not forbid it to root.
///
/// # Errors
/// What the system says.
pub fn folder_is_writable(folder: &Path) -> io::Result<()> {
    let trial = folder.join(format!(".pneudrive-{}", std::process::id()));
    File::create_new(&trial)?;
    remove_file(trial)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_tried_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("page.html");
        assert!(file_is_writable(&file).is_ok() && !file.exists());
        std::fs::write(&file, "precious").unwrap();
        assert!(file_is_writable(&file).is_ok());
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "precious");
        assert_eq!(folder.path().read_dir().unwrap().count(), 1);
        // Not even root makes files there.
        for refused in [Path::new("/proc/page.html"), &folder.path().join("no/page.html"), folder.path()] {
            assert!(file_is_writable(refused).is_err(), "{}", refused.display());
        }
    }
}
