use super::mutation::contents;
use super::scripts;
use bolero::check;
use mcap::write::NoSeek;
use pneudrive_host::poller::{BoardRow, BoardSensors, BoardState, Outcome, Reading, Row};
use pneudrive_model::data::{DataError, Drive, LoadOptions, Loaded, SensorLimits, load, read};
use pneudrive_model::rig::Rig;
use pneudrive_protocol::{Counts, SensorScale};
use pneudrive_record::{RecordedBus, Recorder};
use std::io::Write;
use std::path::Path;

const RECORDING: &[u8] = include_bytes!("seeds/recording.csv");
/// Where every cell counts.
const TWO_ROWS: &[u8] = b"t_s,b0_p0_kpa\n0,1\n0.01,2\n";
const FILE: &str = "fuzzed";

fn limits() -> Option<SensorLimits> {
    let rig = Rig::parse("rig.toml", include_str!("seeds/rig.toml")).unwrap();
    Some(rig.sensor.unwrap().into())
}

/// What a recording promises, whatever the file was.
fn judge(loaded: Result<Loaded, DataError>) {
    let Loaded { recording, quality } = match loaded {
        Ok(loaded) => loaded,
        Err(error) => {
            assert!(error.to_string().contains(FILE), "{error}");
            return;
        }
    };
    let rows = recording.rows();
    assert!(rows >= 2 && rows == recording.time_s.len() && rows == recording.line.len());
    assert!(recording.time_s.iter().all(|t| t.is_finite()));
    assert!(recording.time_s.is_sorted_by(|a, b| a < b), "{:?}", recording.time_s);
    assert!(recording.period_s > 0.0 && recording.rate_hz() > 0.0, "{quality:?}");
    assert!(recording.breaks.iter().all(|row| (1..rows).contains(row)), "{:?}", recording.breaks);
    assert_eq!(quality.rows_kept, rows);
    assert!(quality.rows_read >= rows && quality.findings.iter().all(|finding| finding.count > 0));
    for channel in &recording.channels {
        let drives = match &channel.drive {
            Some(Drive::Spool(u)) => vec![u],
            Some(Drive::Separate { fill, vent }) => vec![fill, vent],
            None => Vec::new(),
        };
        let columns = [&channel.command_kpa, &channel.pressure_kpa].into_iter().flatten().chain(drives);
        assert!(columns.into_iter().all(|column| column.len() == rows));
        assert_eq!(channel.flags.len(), rows);
        assert!(channel.usable_samples() <= rows);
        if let Some(pressures) = &channel.pressure_kpa {
            let usable =
                std::iter::zip(pressures, &channel.flags).filter(|(_, flags)| flags.pressure_usable());
            assert!(usable.into_iter().all(|(kpa, _)| kpa.is_finite()));
        }
    }
    let twice = recording.clone().followed_by(recording);
    assert!(twice.is_ok_and(|twice| twice.rows() == 2 * rows));
}

#[test]
fn csv() {
    let limits = limits();
    let of_all = |_| limits;
    assert!(read(FILE, RECORDING, LoadOptions { limits: Some(&of_all), ..LoadOptions::default() }).is_ok());
    check!().with_iterations(20_000).with_generator(scripts(64)).for_each(|script: &Vec<u8>| {
        let [which, script @ ..] = script.as_slice() else { return };
        let seed = if which % 2 == 0 { RECORDING } else { TWO_ROWS };
        // With limits, what is impossible is masked before anybody sees it.
        let of_all = |_| limits.filter(|_| which / 2 % 2 == 0);
        judge(read(
            FILE,
            &contents(seed, script),
            LoadOptions { limits: Some(&of_all), ..LoadOptions::default() },
        ));
    });
}

/// Whatever is in the file, by its first bytes.
fn from_disk(seed: &[u8], script: &[u8], file: &Path) {
    std::fs::write(file, contents(seed, script)).unwrap();
    judge(load(file, LoadOptions::default()));
}

/// The compressed forms: damage to the framing, to the compressed data, to the checksums.
#[test]
fn compressed() {
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    gzip.write_all(RECORDING).unwrap();
    let seeds = [gzip.finish().unwrap(), zstd::encode_all(RECORDING, 3).unwrap()];
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(FILE);
    for seed in &seeds {
        std::fs::write(&file, seed).unwrap();
        assert!(load(&file, LoadOptions::default()).is_ok());
    }
    check!().with_iterations(5_000).with_generator(scripts(64)).for_each(|script: &Vec<u8>| {
        let [which, script @ ..] = script.as_slice() else { return };
        from_disk(&seeds[usize::from(which % 2)], script, &file);
    });
}

/// A bag of three cycles of two boards, as the host writes it.
fn bag() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let bus = RecordedBus { boards: vec![0, 1], first_joint: 0, unix_offset_ns: 1_700_000_000_000_000_000 };
    let (recorder, taps) = Recorder::create_bag(&file, "/arm", &[bus], SensorScale::ORIGINAL, false).unwrap();
    for mut tap in taps {
        for cycle in 0..3 {
            let at_ns = 1_000_000 * (cycle + 1);
            let counts = [Counts::saturating(102 + 50 * cycle as u16); 4];
            let board = |board: u8| BoardRow {
                board,
                command: counts,
                wanted: counts,
                outcome: Outcome::Fresh,
                reading: Some(Reading {
                    counts,
                    kpa: [0.0; 4],
                    asked_ns: at_ns + 300_000 * u64::from(board),
                }),
                drives: None,
                sensors: BoardSensors::default(),
                state: BoardState::Present,
            };
            let boards = [board(0), board(1)];
            tap.row(&Row { cycle, at_ns, since_start_ns: at_ns - 1_000_000, boards: &boards });
        }
    }
    recorder.finish().unwrap();
    std::fs::read(file).unwrap()
}

/// The same without chunks, compression and checksums, so that damage reaches the messages.
fn plain(bag: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let options = mcap::WriteOptions::new()
        .use_chunks(false)
        .disable_seeking(true)
        .emit_summary_records(false)
        .calculate_data_section_crc(false);
    let mut writer = mcap::Writer::with_options(NoSeek::new(&mut bytes), options).unwrap();
    for message in mcap::MessageStream::new(bag).unwrap() {
        writer.write(&message.unwrap()).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    bytes
}

#[test]
fn bags() {
    let bag = bag();
    let seeds = [plain(&bag), bag];
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(FILE);
    for seed in &seeds {
        std::fs::write(&file, seed).unwrap();
        assert_eq!(load(&file, LoadOptions::default()).unwrap().recording.rows(), 3);
    }
    check!().with_iterations(5_000).with_generator(scripts(64)).for_each(|script: &Vec<u8>| {
        let [which, script @ ..] = script.as_slice() else { return };
        from_disk(&seeds[usize::from(*which < 64)], script, &file);
    });
}
