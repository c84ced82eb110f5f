//! Every kind of unusable data file, and the exact sentence a user reads.

use crate::folder::Folder;
use crate::gzip;
use pneudrive_data::{ChannelId, LoadOptions, load};

/// Loads `text` from a file and returns the error with the folder's path taken out.
fn message(text: &[u8]) -> String {
    let folder = Folder::new();
    let path = folder.write("run.csv", text);
    let error = load(&path, LoadOptions::default()).expect_err("the file cannot be used");
    without_path(&folder, &error.to_string())
}

fn assert_message(text: &str, expected: &str) {
    assert_eq!(message(text.as_bytes()), expected);
}

#[test]
fn a_file_that_is_not_there() {
    let folder = Folder::new();
    let error = load(&folder.path("none.csv"), LoadOptions::default()).unwrap_err();
    assert!(
        without_path(&folder, &error.to_string())
            .starts_with("none.csv: cannot be opened: there is no such file"),
        "{error}"
    );
    let error = load(folder.root(), LoadOptions::default()).unwrap_err();
    assert!(error.to_string().ends_with("cannot be opened: it is a folder; name a file in it"), "{error}");
}

#[test]
fn an_empty_file() {
    let expected =
        "run.csv: the file is empty; a recording starts with a header row such as t_s,b0_cmd0_kpa,b0_p0_kpa";
    assert_message("", expected);
    assert_message("# only a comment\n", expected);
}

#[test]
fn other_formats_are_recognised_by_their_first_bytes() {
    assert_eq!(
        message(b"PK\x03\x04xxxx"),
        "run.csv: this is a zip archive or a spreadsheet, which cannot be read; export it as CSV"
    );
    assert_eq!(
        message(b"PAR1xxxx"),
        "run.csv: this is a Parquet file, which cannot be read; export it as CSV"
    );
}

#[test]
fn a_name_that_promises_something_else() {
    let folder = Folder::new();
    for (name, what) in [("run.csv.zst", "Zstandard"), ("run.csv.gz", "gzip"), ("run.mcap", "MCAP")] {
        let path = folder.write(name, b"\x00\xff\xfe\x93\x00");
        let error = load(&path, LoadOptions::default()).unwrap_err();
        assert_eq!(
            without_path(&folder, &error.to_string()),
            format!(
                "{name}: the content is not {what}, which the name promises: the file is damaged or was renamed; copy it again"
            )
        );
        // Text by another name is read.
        let path = folder.write(name, b"t_s,b0_p0_kpa\n0,1\n0.01,1\n");
        assert!(load(&path, LoadOptions::default()).is_ok(), "{name}");
    }
}

#[test]
fn no_time_column() {
    assert_message(
        "time,b0_p0_kpa\n0,1\n",
        "run.csv, row 1: no column t_s (time in s) among: time, b0_p0_kpa; rename the time column, or use `pneudrive-model import --time`",
    );
    assert_message(
        "t_s;b0_p0_kpa\n0;1\n",
        "run.csv, row 1: no column t_s (time in s) among: t_s;b0_p0_kpa; rename the time column, or use `pneudrive-model import --time`; the columns are separated by semicolons: use `pneudrive-model import --delimiter ';'`",
    );
}

#[test]
fn no_channel_column() {
    assert_message(
        "t_s,b0_p0_psi\n0,1\n",
        "run.csv, row 1: no channel columns such as b0_cmd0_kpa and b0_p0_kpa among: t_s, b0_p0_psi; rename them, or use `pneudrive-model import --map`; is b0_p0_psi meant to be b0_p0_kpa?",
    );
}

#[test]
fn a_column_twice() {
    assert_message(
        "t_s,b0_p0_kpa,b0_p0_kpa\n0,1,1\n",
        "run.csv, row 1: column b0_p0_kpa appears twice; remove or rename one of them",
    );
}

#[test]
fn drives_that_do_not_fit_together() {
    assert_message(
        "t_s,b0_p0_kpa,b0_fill0\n0,1,1\n1,1,1\n",
        "run.csv, row 1: column b0_fill0 has no b0_vent0 beside it; separate fill and vent drives come in pairs (a single spool valve's drive is b{n}_u{k})",
    );
    assert_message(
        "t_s,b0_p0_kpa,b0_fill0,b0_vent0,b0_u0\n0,1,1,0,0\n1,1,1,0,0\n",
        "run.csv, row 1: columns b0_u0 and b0_fill0 both describe the drive of b0c0; keep the ones the valve really got",
    );
}

#[test]
fn a_cell_that_is_no_number() {
    // Rows are lines of the file, also behind the comments of a recording.
    assert_message(
        "# port: \"sim\"\n# rate_hz: 100.0\nt_s,b0_p0_kpa\n0,1\n# event: {\"t_s\":0.01}\n0.01,x\n",
        "run.csv, row 6, column b0_p0_kpa: expected a number, found \"x\"; correct the cell, or leave it empty to have it masked",
    );
    assert_message(
        "# a comment\nt_s,b0_p0_kpa\n0,1\n0.01,1;2\n",
        "run.csv, row 4, column b0_p0_kpa: expected a number, found \"1;2\"; correct the cell, or leave it empty to have it masked",
    );
}

#[test]
fn a_drive_in_another_unit() {
    assert_message(
        "t_s,b0_p0_kpa,b0_u0\n0,1,0.5\n0.01,1,-1.0000001\n0.02,1,250\n",
        "run.csv, row 4, column b0_u0: 250 is outside -1 to 1; a drive runs from -1 (vent) to 1 (fill): divide by the full-scale drive, or import it with a scale",
    );
}

#[test]
fn rows_of_another_width() {
    assert_message(
        "t_s,b0_p0_kpa\n0,1\n0.01,1,2\n",
        "run.csv, row 3: 3 cells where the header has 2 columns; correct or remove the row",
    );
    // Too short in the middle; as the last row it would be a recorder that was killed.
    assert_message(
        "t_s,b0_p0_kpa,b0_cmd0_kpa\n0,1,1\n0.01,1\n0.02,1,1\n",
        "run.csv, row 3: 2 cells where the header has 3 columns; correct or remove the row",
    );
}

#[test]
fn text_that_is_not_utf_8() {
    assert_eq!(
        message(b"t_s,b0_p0_kpa\n0,1\n0.01,\xff\xfe\n"),
        "run.csv, row 3: not valid UTF-8 text; save the file as plain CSV in UTF-8"
    );
}

#[test]
fn too_few_rows() {
    assert_message(
        "t_s,b0_p0_kpa\n0,1\n",
        "run.csv: usable rows: 1; a recording needs at least 2, and fitting a few hundred.",
    );
}

/// It would be infinite in single precision.
#[test]
fn a_pressure_that_is_none() {
    assert_message(
        "t_s,b0_p0_kpa\n0,1\n0.01,1e9\n",
        "run.csv, row 3, column b0_p0_kpa: 1000000000 is outside -100000000 to 100000000; that is no pressure in kPa; leave the cell empty where there is none",
    );
}

/// The period, or its inverse, would be zero.
#[test]
fn times_that_give_no_rate() {
    for (times, rate) in [(["0", "5e-324"], "inf"), (["0", "1e13"], "1e-13")] {
        let text = format!("t_s,b0_p0_kpa\n{},1\n{},1\n", times[0], times[1]);
        let expected = format!(
            "run.csv: t_s gives a sampling rate of {rate} Hz, which nothing was recorded at: it must be in seconds"
        );
        assert_message(&text, &expected);
    }
    // One wild time stamp costs its row.
    assert_message(
        "t_s,b0_p0_kpa\n0,1\n-1e300,1\n1e300,1\n",
        "run.csv: usable rows: 1; a recording needs at least 2, and fitting a few hundred. t_s is empty or no usable number in 2 row(s), the first of them row 3: left out.",
    );
}

#[test]
fn a_cut_off_archive_names_the_last_row_read() {
    let folder = Folder::new();
    let rows: String =
        (0..20_000).map(|k| format!("{},{}\n", f64::from(k) * 0.01, (k * 7919) % 1000)).collect();
    let whole = gzip(format!("t_s,b0_p0_kpa\n{rows}").as_bytes());
    let path = folder.write("run.csv.gz", &whole[..whole.len() / 2]);
    let error = load(&path, LoadOptions::default()).unwrap_err().to_string();
    let text = without_path(&folder, &error);
    assert!(text.starts_with("run.csv.gz: reading failed after row "), "{text}");
    assert!(text.ends_with("the file may be cut off or damaged, copy it again"), "{text}");
}

#[test]
fn a_channel_that_is_not_there() {
    let folder = Folder::new();
    let path = folder.write("run.csv", b"t_s,b0_p0_kpa,b1_p3_kpa\n0,1,1\n1,1,1\n");
    let wanted = [ChannelId { board: 2, channel: 0 }];
    let error = load(&path, LoadOptions { channels: Some(&wanted), ..LoadOptions::default() }).unwrap_err();
    assert_eq!(
        without_path(&folder, &error.to_string()),
        "run.csv: no channel b2c0; the file has b0c0, b1c3"
    );
}

/// A message without the folder's path.
fn without_path(folder: &Folder, message: &str) -> String {
    message.replace(&format!("{}/", folder.root().display()), "")
}
