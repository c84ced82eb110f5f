//! The loop of a rig's life: a healthy rig is checked and calibrated; a leak grows; the watch says
//! so; the diagnosis against the calibrated model names it; the check confirms it, and the repair.
//!
//! Boards, host, recorder and models are the real ones, in virtual time: the result does not depend
//! on the machine.

use std::path::{Path, PathBuf};

use pneudrive_host::check::{Quantity, Verdict};
use pneudrive_model::data::{ChannelId, LiveTable, LoadOptions, Opening, Recording, load};
use pneudrive_model::diagnosis::{ExtendedFile, Request, diagnose};
use pneudrive_model::experiment::{FitSettings, fit_channels};
use pneudrive_model::fit::Control;
use pneudrive_model::rig::Rig;
use pneudrive_model::store::ParameterFile;
use pneudrive_model::watch::{Change, Rows, WatchEvent, WatchSettings, Watcher, Where};
use pneudrive_sim::rig::RigOptions;
use system_tests::self_check::{alarms, check, laboratory, with_fault};
use system_tests::take::Take;

const SEED: u64 = 77;
/// The channel that will leak.
const LEAKS: ChannelId = ChannelId { board: 0, channel: 2 };
/// Length of the stretch that the watch learns from, s.
const LEARN_S: f64 = 300.0;

/// Commands of channels 1 and 2: steps and holds between 40 and 220 kPa, which look random; others
/// with another seed.
fn movements(seconds: f64, seed: u32) -> String {
    let mut text = "t_s,b0_cmd1_kpa,b0_cmd2_kpa\n".to_owned();
    let scatter = |k: u32| f64::from((k + seed).wrapping_mul(2_654_435_761) >> 8) / f64::from(1_u32 << 24);
    let (mut t_s, mut k) = (0.0, 0);
    while t_s < seconds {
        let level = |place: u32| 40.0 + 180.0 * scatter(3 * k + place);
        text.push_str(&format!("{t_s:.3},{:.1},{:.1}\n", level(0), level(1)));
        t_s += 0.3 + 1.2 * scatter(3 * k + 2);
        k += 1;
    }
    text.push_str(&format!("{seconds:.3},100,100\n"));
    text
}

/// The host plays commands to the boards of a rig and records what they answer, with the valves'
/// drives.
fn play(rig: &RigOptions, commands: &str, file: &Path) -> PathBuf {
    Take { commands, rate_hz: 100, drives: true, begins_s: 3.0 }.record(rig, file);
    file.to_owned()
}

fn recording(file: &Path, rig: &Rig, channels: &[ChannelId]) -> Recording {
    let limits = |channel| rig.sensor_limits(channel);
    let options = LoadOptions { limits: Some(&limits), channels: Some(channels), ..LoadOptions::default() };
    load(file, options).unwrap().recording
}

/// Shows a recording to the watcher, beginning at `from_s` on its time axis.
fn show(watcher: &mut Watcher, file: &Path, from_s: f64) -> Vec<WatchEvent> {
    let mut rows = Rows::new(LiveTable::open(Opening::Whole(file)).unwrap());
    let mut said = Vec::new();
    while let Some(mut row) = rows.next_row().unwrap() {
        row.t_s += from_s;
        watcher.take(row, &mut |event| said.push(event));
    }
    said
}

fn changes(said: Vec<WatchEvent>) -> Vec<Change> {
    let change = |event| match event {
        WatchEvent::Changed(change) => Some(change),
        WatchEvent::Learnt(_) => None,
    };
    said.into_iter().filter_map(change).collect()
}

#[test]
fn a_leak_that_grows_is_seen_named_and_seen_to_be_mended() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let healthy = laboratory(SEED);
    let leaking = |area: f64| with_fault(healthy.clone(), &format!("exhaust_leak={area}@b0c2"));
    let nominal = Rig::parse("rig.toml", &healthy.rig_toml().unwrap()).unwrap();
    let both = [ChannelId { board: 0, channel: 1 }, LEAKS];

    // Healthy: checked and calibrated.
    let baseline = check(&healthy, 0.5, None);
    assert!(!alarms(&baseline), "{baseline:?}");
    let first = recording(&play(&healthy, &movements(60.0, 1), &path("first.csv")), &nominal, &both);
    let mut how = FitSettings::default();
    how.fit.starts = 4;
    let fitted = fit_channels(&first, &nominal, &how, Control::none()).unwrap();
    let toml = path("calibrated.toml");
    ParameterFile::of(&first, &nominal, &how, &fitted).unwrap().save(&toml).unwrap();
    let calibrated = ExtendedFile::load(&toml).unwrap();

    // Watched: nothing while it is healthy, the leak once it has grown.
    let usual = play(&healthy, &movements(LEARN_S + 60.0, 2), &path("usual.csv"));
    let columns = Rows::new(LiveTable::open(Opening::Whole(&usual)).unwrap()).columns().to_vec();
    let settings = WatchSettings { learn_s: LEARN_S };
    let mut watcher = Watcher::new(("calibrated.toml", &calibrated), columns, settings).unwrap();
    let said = show(&mut watcher, &usual, 0.0);
    assert_eq!(said.len(), 2, "both channels are learnt, and nothing has changed: {said:?}");
    let mut seen = Vec::new();
    for (place, area) in (0..).zip([0.003, 0.01, 0.02]) {
        let grown = play(&leaking(area), &movements(60.0, 3 + place), &path(&format!("{place}.csv")));
        seen.extend(changes(show(&mut watcher, &grown, LEARN_S + 61.0 + 61.0 * f64::from(place))));
    }
    let change = seen.first().expect("the watch sees the leak");
    assert_eq!(change.channel, LEAKS, "{seen:?}");
    let leak = change.explanations.iter().find(|explanation| explanation.effect == "exhaust_leak").unwrap();
    assert!(leak.place == Where::Channel(LEAKS) && leak.probability > 0.5, "{change:?}");
    assert!(change.since_ci95_s[1] >= LEARN_S + 60.0, "not before it was there: {change:?}");

    // Diagnosed against the calibrated model.
    let after = recording(&path("2.csv"), &nominal, &[LEAKS]);
    let request = Request { reference: Some(("calibrated.toml", &calibrated)), ..Request::default() };
    let diagnosis = diagnose(&after, &nominal, request, &|_, _| {}).unwrap();
    let named: Vec<&str> = diagnosis.report.causes.iter().map(|cause| cause.effect.as_str()).collect();
    assert_eq!(named, ["exhaust_leak"], "{}", diagnosis.report.sentence);

    // Checked: the leak, and that it is mended.
    let worn = check(&leaking(0.02), 1.3, Some(&baseline));
    let problems: Vec<(Quantity, usize)> =
        worn.boards[0].problems().map(|value| (value.quantity, value.channel)).collect();
    let shows = [Quantity::Leak, Quantity::Hold, Quantity::Reached];
    assert!(problems.iter().any(|(quantity, _)| shows.contains(quantity)), "{problems:?}");
    assert!(problems.iter().all(|(_, channel)| *channel == 2), "{problems:?}");
    let mended = check(&healthy, 2.1, Some(&baseline));
    assert_eq!(mended.verdict, Verdict::Pass, "{mended:?}");
}
