use super::*;

const ID: ChannelId = ChannelId { board: 0, channel: 0 };

/// 10 s at 100 Hz: a sine of pressure and a drive that leads it.
fn wave() -> (Vec<f64>, Vec<u32>, Vec<f32>, Vec<f32>) {
    let time: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
    let line: Vec<u32> = (2..1002).collect();
    let pressure = time.iter().map(|t| (100.0 + 50.0 * t.sin()) as f32).collect();
    let drive = time.iter().map(|t| t.cos() as f32).collect();
    (time, line, pressure, drive)
}

#[test]
fn a_frozen_reading_is_masked() {
    let (time, line, mut pressure, drive) = wave();
    let value = pressure[300];
    pressure[300..400].fill(value);
    let drive = Drive::Spool(drive);
    let told = Told { command_kpa: None, drive: Some(&drive) };
    let mut flags = vec![Flags::NONE; 1000];
    let finding = mark_stuck(ID, &time, &line, &pressure, &told, &mut flags).expect("it is stuck");
    assert_eq!(finding.count, 100);
    assert!(flags[300..400].iter().all(|f| f.contains(Flags::STUCK)));
    assert!(!flags[299].contains(Flags::STUCK) && !flags[400].contains(Flags::STUCK));
}

#[test]
fn a_chamber_at_rest_is_not_stuck() {
    let (time, line, mut pressure, _) = wave();
    pressure.fill(120.0);
    let told = Told { command_kpa: Some(&vec![120.0; 1000]), drive: None };
    let mut flags = vec![Flags::NONE; 1000];
    assert_eq!(mark_stuck(ID, &time, &line, &pressure, &told, &mut flags), None);
}

const COUNT_KPA: f64 = 0.841_645;

/// Time, lines, pressure, command, drive.
type Staircase = (Vec<f64>, Vec<u32>, Vec<f32>, Vec<f32>, Vec<f32>);

/// 24 s at 100 Hz of a loop that holds levels two counts low, behind 20 ms of dead time and a lag
/// of 50 ms, without noise. The pressure is in whole counts.
fn staircase(levels_kpa: [f64; 8]) -> Staircase {
    let time: Vec<f64> = (0..2400).map(|k| 0.01 * f64::from(k)).collect();
    let command: Vec<f64> = (0..2400).map(|k| levels_kpa[k / 300]).collect();
    let (mut kpa, mut pressure, mut drive) = (levels_kpa[0] - 2.0 * COUNT_KPA, Vec::new(), Vec::new());
    for row in 0..2400_usize {
        kpa += (command[row.saturating_sub(2)] - 2.0 * COUNT_KPA - kpa) * 0.01 / 0.05;
        let reading = (kpa / COUNT_KPA).round() * COUNT_KPA;
        pressure.push(reading as f32);
        drive.push(((command[row] - reading) / COUNT_KPA / 40.0).clamp(-1.0, 1.0) as f32);
    }
    (time, (2..2402).collect(), pressure, command.iter().map(|kpa| *kpa as f32).collect(), drive)
}

/// Holds are constant, and the first samples after the next step still are.
#[test]
fn holds_between_steps_are_not_stuck() {
    let (time, line, pressure, command, drive) =
        staircase([100.0, 200.0, 100.0, 150.0, 120.0, 180.0, 60.0, 100.0]);
    let holding = equal_runs(&pressure).iter().map(Range::len).sum::<usize>();
    assert!(holding > 2000, "{holding} of 2400 rows are exact repeats");
    let drive = Drive::Spool(drive);
    for told in [
        Told { command_kpa: Some(&command), drive: None },
        Told { command_kpa: Some(&command), drive: Some(&drive) },
    ] {
        let mut flags = vec![Flags::NONE; 2400];
        assert_eq!(mark_stuck(ID, &time, &line, &pressure, &told, &mut flags), None);
        assert!(flags.iter().all(|flag| *flag == Flags::NONE));
    }
}

/// The same, but from 7 s on nothing changes any more: the hold that was under way, and what should
/// have followed.
#[test]
fn a_sensor_that_freezes_in_a_hold_is_stuck() {
    let (time, line, mut pressure, command, drive) =
        staircase([100.0, 200.0, 100.0, 150.0, 120.0, 180.0, 60.0, 100.0]);
    let value = pressure[700];
    pressure[700..1600].fill(value);
    let drive = Drive::Spool(drive);
    for told in [
        Told { command_kpa: Some(&command), drive: None },
        Told { command_kpa: Some(&command), drive: Some(&drive) },
    ] {
        let mut flags = vec![Flags::NONE; 2400];
        mark_stuck(ID, &time, &line, &pressure, &told, &mut flags).expect("it is stuck");
        assert!(flags[700..1600].iter().all(|flag| flag.contains(Flags::STUCK)));
        assert!(flags[1600..].iter().all(|flag| *flag == Flags::NONE));
    }
}

/// Valves have overlap: a set point that moves by less than a few counts need not move anything.
#[test]
fn small_signals_within_a_valves_overlap_are_not_stuck() {
    let (time, line, mut pressure, _, _) = staircase([100.0; 8]);
    pressure[0] += COUNT_KPA as f32;
    let command: Vec<f32> = time.iter().map(|t_s| (100.0 + 1.5 * t_s.sin()) as f32).collect();
    let told = Told { command_kpa: Some(&command), drive: None };
    let mut flags = vec![Flags::NONE; 2400];
    assert_eq!(mark_stuck(ID, &time, &line, &pressure, &told, &mut flags), None);
}

#[test]
fn an_empty_chamber_that_is_vented_is_not_stuck_but_one_that_is_filled_is() {
    let (time, line, mut pressure, _) = wave();
    pressure[..500].fill(0.0);
    let venting: Vec<f32> = (0..1000).map(|k| if k % 100 < 50 { -1.0 } else { -0.2 }).collect();
    let mut flags = vec![Flags::NONE; 1000];
    let drive = Drive::Spool(venting.clone());
    let told = Told { command_kpa: None, drive: Some(&drive) };
    assert_eq!(mark_stuck(ID, &time, &line, &pressure, &told, &mut flags), None);
    let drive = Drive::Spool(venting.iter().map(|u| -u).collect());
    let told = Told { command_kpa: None, drive: Some(&drive) };
    assert!(mark_stuck(ID, &time, &line, &pressure, &told, &mut flags).is_some());
}

#[test]
fn a_sensor_that_never_moves_is_stuck() {
    let (time, line, mut pressure, drive) = wave();
    pressure.fill(33.0);
    let command: Vec<f32> = drive.iter().map(|u| 100.0 * u).collect();
    let told = Told { command_kpa: Some(&command), drive: None };
    let mut flags = vec![Flags::NONE; 1000];
    assert_eq!(mark_stuck(ID, &time, &line, &pressure, &told, &mut flags).map(|f| f.count), Some(1000));
}
