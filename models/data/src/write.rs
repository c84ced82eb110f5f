//! Writing results: whole or not at all.

use std::fs::Permissions;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::{Channel, DataError, Drive, Recording};

/// Writes `path` through a temporary file beside it that takes its place when `content` has
/// succeeded, so that nobody ever sees half a file.
///
/// # Errors
/// Whatever `content` returns, or [`DataError::Write`] naming `path`.
pub fn atomically<E: From<DataError>>(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    let failed = |source| DataError::Write { file: path.display().to_string(), source };
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pneudrive-").suffix(".partial");
    // As any other new file: what the umask leaves. A temporary file would be private.
    #[cfg(unix)]
    let builder = builder.permissions(<Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o666));
    let file = builder.tempfile_in(folder).map_err(failed)?;
    let mut writer = BufWriter::with_capacity(1 << 16, file);
    content(&mut writer)?;
    let file = writer.into_inner().map_err(|e| failed(e.into_error()))?;
    file.persist(path).map_err(|e| failed(e.error))?;
    Ok(())
}

/// Writes text to `path`, whole or not at all.
///
/// # Errors
/// [`DataError::Write`] naming `path`.
pub fn text_atomically(path: &Path, text: &str) -> Result<(), DataError> {
    atomically(path, |writer| {
        writer
            .write_all(text.as_bytes())
            .map_err(|source| DataError::Write { file: path.display().to_string(), source })
    })
}

/// Runs `content` on a writer that compresses as the extension of `path` says: `.gz`, `.zst`, or
/// not.
///
/// # Errors
/// As [`atomically`].
pub fn compressed_atomically<E: From<DataError>>(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    /// Zstandard's own default.
    const ZSTD_LEVEL: i32 = 3;
    let failed = |source| DataError::Write { file: path.display().to_string(), source };
    atomically(path, |plain| match path.extension().and_then(|e| e.to_str()) {
        Some("gz") => {
            let mut encoder = flate2::write::GzEncoder::new(plain, flate2::Compression::default());
            content(&mut encoder)?;
            encoder.finish().map_err(failed)?;
            Ok(())
        }
        Some("zst") => {
            let mut encoder = zstd::stream::write::Encoder::new(plain, ZSTD_LEVEL).map_err(failed)?;
            content(&mut encoder)?;
            encoder.finish().map_err(failed)?;
            Ok(())
        }
        _ => content(plain),
    })
}

/// Writes a recording in the measured-data format, compressed as the extension says. Missing values
/// become empty cells.
///
/// # Errors
/// [`DataError::Write`] naming `path`.
pub fn recording(path: &Path, recording: &Recording) -> Result<(), DataError> {
    compressed_atomically(path, |writer| {
        rows(writer, recording)
            .map_err(|source| DataError::Write { file: path.display().to_string(), source })
    })
}

fn rows(writer: &mut dyn Write, recording: &Recording) -> io::Result<()> {
    let mut columns: Vec<(String, &[f32])> = Vec::new();
    for channel in &recording.channels {
        channel_columns(channel, &mut columns);
    }
    for joint in &recording.joints {
        columns.extend(joint.qu_rad.as_deref().map(|q| (format!("b{}_qu_rad", joint.board), q)));
        columns.extend(joint.qv_rad.as_deref().map(|q| (format!("b{}_qv_rad", joint.board), q)));
    }
    columns.extend(recording.supply_kpa.as_deref().map(|p| ("supply_kpa".to_owned(), p)));
    columns.extend(recording.board_supplies.iter().map(|p| (format!("b{}_supply_kpa", p.board), &p.kpa[..])));

    write!(writer, "t_s")?;
    for (name, _) in &columns {
        write!(writer, ",{name}")?;
    }
    writeln!(writer)?;
    for (row, time) in recording.time_s.iter().enumerate() {
        write!(writer, "{time}")?;
        for (_, values) in &columns {
            // The shortest text that reads back as the same number.
            if values[row].is_nan() { write!(writer, ",")? } else { write!(writer, ",{}", values[row])? }
        }
        writeln!(writer)?;
    }
    Ok(())
}

fn channel_columns<'a>(channel: &'a Channel, columns: &mut Vec<(String, &'a [f32])>) {
    columns.extend(channel.command_kpa.as_deref().map(|v| (channel.id.command_column(), v)));
    columns.extend(channel.pressure_kpa.as_deref().map(|v| (channel.id.pressure_column(), v)));
    match &channel.drive {
        Some(Drive::Spool(u)) => columns.push((channel.id.drive_column(), u)),
        Some(Drive::Separate { fill, vent }) => {
            let (fill_name, vent_name) = channel.id.fill_vent_columns();
            columns.push((fill_name, fill));
            columns.push((vent_name, vent));
        }
        None => {}
    }
}
