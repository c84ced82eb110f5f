//! Writing recordings in the measured-data format.

use std::cell::Cell;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use flate2::write::GzEncoder;

use crate::plant::CHANNELS_PER_BOARD;

use super::error::RecordError;
use super::recorder::Row;
use super::settings::Columns;

/// Writes rows to `path`, plain (`.csv`), gzip (`.csv.gz`) or zstd (`.csv.zst`); returns how many.
///
/// The file appears under its name when it is complete.
///
/// # Errors
/// A name with another ending, or a file that cannot be written.
pub fn write_csv(
    path: &Path,
    channels: usize,
    columns: Columns,
    rows: impl IntoIterator<Item = Row>,
) -> Result<u64, RecordError> {
    write_csv_until(path, channels, columns, rows, || false)
}

/// As [`write_csv`], but gives up as soon as `stop` says so: then there is no file.
pub(super) fn write_csv_until(
    path: &Path,
    channels: usize,
    columns: Columns,
    rows: impl IntoIterator<Item = Row>,
    stop: impl Fn() -> bool,
) -> Result<u64, RecordError> {
    let name = path.to_string_lossy();
    let mut partial = path.as_os_str().to_owned();
    partial.push(".partial");
    let partial = PathBuf::from(partial);
    let kind = Kind::of(&name).ok_or_else(|| RecordError::Extension { path: path.to_owned() })?;
    let not_created =
        |error: std::io::Error| RecordError::NotCreated { path: path.to_owned(), reason: error.to_string() };
    let file = BufWriter::new(File::create(&partial).map_err(not_created)?);
    // Compressed files are ended properly after the last row that there is; whether it is the last
    // one asked for is looked at afterwards.
    let stopped = Cell::new(false);
    let rows = rows.into_iter().take_while(|_| {
        stopped.set(stopped.get() || stop());
        !stopped.get()
    });
    let written = match kind {
        Kind::Plain => write_rows(file, channels, columns, rows).and_then(|(mut f, n)| f.flush().map(|()| n)),
        Kind::Gzip => {
            let encoder = GzEncoder::new(file, flate2::Compression::default());
            write_rows(encoder, channels, columns, rows).and_then(|(e, n)| e.finish()?.flush().map(|()| n))
        }
        Kind::Zstd => zstd::Encoder::new(file, 3)
            .and_then(|encoder| write_rows(encoder, channels, columns, rows))
            .and_then(|(e, n)| e.finish()?.flush().map(|()| n)),
    };
    let failed = |source| RecordError::Write { path: path.to_owned(), source };
    let finished = match written {
        Ok(_) if stopped.get() => Err(RecordError::Interrupted { path: path.to_owned() }),
        Ok(n) => std::fs::rename(&partial, path).map(|()| n).map_err(failed),
        Err(source) => Err(failed(source)),
    };
    finished.inspect_err(|_| {
        // The error that matters is the first one; a leftover that cannot be removed either is
        // named by its ending.
        drop(std::fs::remove_file(&partial));
    })
}

enum Kind {
    Plain,
    Gzip,
    Zstd,
}

impl Kind {
    fn of(name: &str) -> Option<Self> {
        if name.ends_with(".csv") {
            Some(Self::Plain)
        } else if name.ends_with(".csv.gz") {
            Some(Self::Gzip)
        } else if name.ends_with(".csv.zst") {
            Some(Self::Zstd)
        } else {
            None
        }
    }
}

fn write_rows<W: Write>(
    out: W,
    channels: usize,
    columns: Columns,
    rows: impl IntoIterator<Item = Row>,
) -> std::io::Result<(W, u64)> {
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record(header(channels, columns))?;
    let mut count = 0;
    for row in rows {
        csv.write_record(fields(&row, channels, columns))?;
        count += 1;
    }
    let out = csv.into_inner().map_err(|e| std::io::Error::other(e.error().to_string()))?;
    Ok((out, count))
}

fn header(channels: usize, columns: Columns) -> Vec<String> {
    let mut names = vec!["t_s".to_owned()];
    for first in (0..channels).step_by(CHANNELS_PER_BOARD) {
        let board = first / CHANNELS_PER_BOARD;
        let count = (channels - first).min(CHANNELS_PER_BOARD);
        if columns.command {
            names.extend((0..count).map(|k| format!("b{board}_cmd{k}_kpa")));
        }
        names.extend((0..count).map(|k| format!("b{board}_p{k}_kpa")));
        if columns.drive {
            names.extend((0..count).map(|k| format!("b{board}_u{k}")));
        }
        if columns.joints {
            names.extend([format!("b{board}_qu_rad"), format!("b{board}_qv_rad")]);
        }
    }
    if columns.supply {
        names.push("supply_kpa".to_owned());
    }
    names
}

fn fields(row: &Row, channels: usize, columns: Columns) -> Vec<String> {
    // Times to the nanosecond, pressures to the pascal's thousandth, drives exactly: they are what
    // a simulation is fed with.
    let mut out = vec![format!("{:.9}", row.t_s)];
    for first in (0..channels).step_by(CHANNELS_PER_BOARD) {
        let own = first..(first + CHANNELS_PER_BOARD).min(channels);
        if columns.command {
            out.extend(row.command_kpa[own.clone()].iter().map(|v| format!("{v:.6}")));
        }
        out.extend(row.pressure_kpa[own.clone()].iter().map(|v| format!("{v:.6}")));
        if columns.drive {
            out.extend(row.drive[own].iter().map(f64::to_string));
        }
        if columns.joints {
            out.extend(row.angles_rad[first / CHANNELS_PER_BOARD].iter().map(|v| format!("{v:.9}")));
        }
    }
    if columns.supply {
        out.push(format!("{:.6}", row.supply_kpa));
    }
    out
}
