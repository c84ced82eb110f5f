//! What the loader masks, counts and says; and that it reads what it should.

use crate::folder::Folder;
use crate::gzip;
use pneudrive_data::{ChannelId, Drive, FindingKind, Flags, LoadOptions, Loaded, SensorLimits, load, write};

fn loaded(text: &str) -> Loaded {
    let folder = Folder::new();
    let path = folder.write("run.csv", text.as_bytes());
    load(&path, LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// 100 Hz; pressure, command and drive move all the time.
fn rows(count: u32) -> Vec<String> {
    (0..count)
        .map(|k| {
            let t = f64::from(k) * 0.01;
            format!(
                "{t:.2},{:.3},{:.3},{:.3}",
                100.0 + 50.0 * t.sin(),
                100.0 + 50.0 * (t + 0.1).sin(),
                t.cos()
            )
        })
        .collect()
}

const HEADER: &str = "t_s,b0_p0_kpa,b0_cmd0_kpa,b0_u0";

fn file(rows: &[String]) -> String {
    format!("{HEADER}\n{}\n", rows.join("\n"))
}

#[test]
fn a_clean_recording_has_no_findings() {
    let Loaded { recording, quality } = loaded(&file(&rows(500)));
    assert_eq!(quality.findings, []);
    assert_eq!((quality.rows_read, quality.rows_kept, recording.rows()), (500, 500, 500));
    assert!((quality.sampling.rate_hz - 100.0).abs() < 1e-6);
    assert_eq!((recording.segments().len(), recording.segments()[0].clone()), (1, 0..500));
    let channel = recording.channel(ChannelId { board: 0, channel: 0 }).unwrap();
    assert_eq!(channel.usable_samples(), 500);
    assert!(matches!(channel.drive, Some(Drive::Spool(_))));
    assert_eq!(
        quality.sentences(),
        ["Sampled at 100 Hz, step jitter 0 ms (standard deviation), longest step 10 ms."]
    );
}

#[test]
fn missing_cells_are_masked_and_named() {
    let mut rows = rows(300);
    rows[9] = "0.09,,100,0".to_owned();
    rows[10] = "0.10,NaN,100,0".to_owned();
    rows[20] = "0.20,100,100,".to_owned();
    let Loaded { recording, quality } = loaded(&file(&rows));
    let flags = &recording.channels[0].flags;
    assert!(flags[9].contains(Flags::PRESSURE_MISSING) && flags[10].contains(Flags::PRESSURE_MISSING));
    assert_eq!(recording.channels[0].usable_samples(), 298);
    assert!(flags[20].contains(Flags::INPUT_HELD));
    let said: Vec<&str> = quality.findings.iter().map(|f| f.sentence.as_str()).collect();
    assert_eq!(
        said,
        [
            "b0_u0: 1 cell is empty or not a number (row 22); the last value is held in 1 of them (up to 5 in a row), and no simulation passes the other 0.",
            "b0_p0_kpa: 2 cells are empty or not a number (rows 11 to 12); nothing is compared with the simulation there.",
        ]
    );
}

#[test]
fn a_long_missing_drive_ends_the_simulation() {
    let mut rows = rows(300);
    for (k, row) in rows.iter_mut().enumerate().take(160).skip(100) {
        *row = format!("{:.2},100.{k},100,", f64::from(u32::try_from(k).unwrap()) * 0.01);
    }
    let Loaded { recording, .. } = loaded(&file(&rows));
    assert_eq!(recording.channel_segments(&recording.channels[0]), [0..100, 160..300]);
}

#[test]
fn duplicate_and_unsorted_rows_are_left_out() {
    let mut rows = rows(300);
    rows[50] = rows[49].clone();
    rows.swap(100, 101);
    let Loaded { recording, quality } = loaded(&file(&rows));
    assert_eq!((quality.rows_read, quality.rows_kept), (300, 298));
    assert!(recording.time_s.windows(2).all(|w| w[0] < w[1]));
    let finding = quality.of_kind(FindingKind::TimeOrder).next().expect("said");
    assert_eq!(finding.count, 2);
}

#[test]
fn gaps_are_bridged_or_end_the_stretch() {
    let mut rows = rows(500);
    rows.drain(300..350);
    rows.remove(100);
    let Loaded { recording, quality } = loaded(&file(&rows));
    assert_eq!(recording.breaks, [299]);
    assert_eq!(
        quality.findings[0].sentence,
        "2 gaps are longer than 1.5 sampling periods, 0.51 s in all, 10.2 % of the time (rows 101 to 102, 300 to 301): inputs are held over 1, the simulation starts anew after 1."
    );
}

#[test]
fn a_stuck_sensor_is_masked() {
    let mut rows = rows(500);
    for row in &mut rows[200..300] {
        let mut cells: Vec<&str> = row.split(',').collect();
        cells[1] = "123.4";
        *row = cells.join(",");
    }
    let Loaded { recording, quality } = loaded(&file(&rows));
    assert_eq!(quality.of_kind(FindingKind::StuckSensor).map(|f| f.count).collect::<Vec<_>>(), [100]);
    assert_eq!(recording.channels[0].usable_samples(), 400);
}

#[test]
fn saturated_samples_are_masked_when_the_rig_names_the_limits() {
    let folder = Folder::new();
    let path = folder.write("run.csv", file(&rows(700)).as_bytes());
    let limits = |_| Some(SensorLimits { low_kpa: 60.0, high_kpa: 140.0, step_kpa: 0.1 });
    let with = load(&path, LoadOptions { limits: Some(&limits), ..LoadOptions::default() }).unwrap();
    let without = load(&path, LoadOptions::default()).unwrap();
    let masked = with.quality.of_kind(FindingKind::Saturated).next().expect("beyond the limits").count;
    // 50 sin(t) is beyond +-40 for 2 (pi/2 - asin 0.8) = 1.287 s in each half wave, 2 half waves in
    // 7 s.
    assert!((250..=265).contains(&masked), "{masked}");
    assert_eq!(with.recording.channels[0].usable_samples(), 700 - masked);
    assert_eq!(without.recording.channels[0].usable_samples(), 700);
}

#[test]
fn a_killed_recorder_costs_its_last_row() {
    let mut text = file(&rows(300));
    text.push_str("3.00,10");
    let Loaded { quality, .. } = loaded(&text);
    assert_eq!((quality.rows_read, quality.rows_kept), (301, 300));
    assert_eq!(quality.findings[0].sentence, "The last row (302) stops in the middle and is left out.");
}

#[test]
fn rows_without_time_are_left_out_and_odd_columns_mentioned() {
    let text = "t_s,b0_p0_kpa,b0_p1_psi,note\n0,1,1,7\n,2,2,7\n0.01,3,3,7\n0.02,4,4,7\n";
    let Loaded { quality, .. } = loaded(text);
    let said: Vec<&str> = quality.findings.iter().map(|f| f.sentence.as_str()).collect();
    assert_eq!(
        said[..2],
        [
            "Column b0_p1_psi is not used: the format knows b0_p1_kpa. Rename it if that is what it is, or convert its unit with `pneudrive-model import --map`.",
            "t_s is empty or no usable number in 1 row(s), the first of them row 3: left out.",
        ]
    );
}

#[test]
fn plain_gzip_and_zstd_read_the_same_whatever_the_name() {
    let folder = Folder::new();
    let text = file(&rows(400));
    let plain = folder.write("a.csv", text.as_bytes());
    let zipped = folder.write("b.csv", &gzip(text.as_bytes()));
    let zstd = folder.write("c.gz", &zstd::encode_all(text.as_bytes(), 3).unwrap());
    let read = |path: &std::path::Path| load(path, LoadOptions::default()).unwrap().recording;
    let (a, b, c) = (read(&plain), read(&zipped), read(&zstd));
    for other in [&b, &c] {
        assert_eq!((&a.time_s, &a.channels), (&other.time_s, &other.channels));
    }
    assert_ne!(a.source.sha256, b.source.sha256);
    // What `printf 't_s,b0_p0_kpa\n0,1\n1,2\n' | sha256sum` prints.
    let known = folder.write("d.csv", b"t_s,b0_p0_kpa\n0,1\n1,2\n");
    assert_eq!(
        read(&known).source.sha256,
        "aea2d0cbc662705195dd4cd2eeb201e65a3ac9370f7be62218b08469e38130bf"
    );
}

#[test]
fn a_written_recording_reads_back_the_same() {
    let folder = Folder::new();
    let text = "t_s,b1_cmd2_kpa,b1_p2_kpa,b1_fill2,b1_vent2,b1_qu_rad,b1_qv_rad,supply_kpa\n0,1.5,2.25,0,1,0.1,0.2,550\n0.01,1.5,,0.25,0.5,0.1,0.2,549.5\n0.02,1,3,0,1,0.1,0.2,551\n";
    let first = load(&folder.write("a.csv", text.as_bytes()), LoadOptions::default()).unwrap().recording;
    for name in ["b.csv", "b.csv.gz", "b.csv.zst"] {
        let path = folder.path(name);
        write::recording(&path, &first).unwrap();
        let mut again = load(&path, LoadOptions::default()).unwrap().recording;
        again.source = first.source.clone();
        // NaN is not equal to itself: compare what is printed.
        assert_eq!(format!("{again:?}"), format!("{first:?}"), "{name}");
    }
    let magic = |name: &str| std::fs::read(folder.path(name)).unwrap()[..2].to_vec();
    assert_eq!((magic("b.csv.gz"), magic("b.csv.zst")), (vec![0x1f, 0x8b], vec![0x28, 0xb5]));
    assert_eq!(folder.names(), ["a.csv", "b.csv", "b.csv.gz", "b.csv.zst"]);
}
