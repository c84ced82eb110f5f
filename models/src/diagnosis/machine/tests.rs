use super::candidates::possible;
use super::fit::{fit_base, known_base};
use super::loads::differ;
use super::recordings::{MachineChannel, split_in_three};
use super::search::{Findings, find};
use crate::diagnosis::channel::Extended;
use crate::diagnosis::evidence::Missing;
use crate::diagnosis::screening::Asked;
use crate::diagnosis::testing::{STRUCTURE, channel, measured, with};
use crate::effects::catalogue::{CATALOGUE, index_of};

/// Recordings of one valve with these volumes, and tubes of these time constants where there are
/// any.
fn machine(volumes: &[f64], tubes_s: &[f64]) -> MachineChannel {
    let (data, base) = channel(false);
    let recorded = volumes.iter().enumerate().map(|(k, &volume)| {
        let mut data = data.clone();
        split_in_three(&mut data);
        let mut truth = with(&data, &base, "chamber_volume", &[volume]);
        if let Some(&tube_s) = tubes_s.get(k) {
            truth = with(&data, &truth, "line_restriction", &[tube_s, 0.05, 2.0]);
        }
        measured(data, &truth, k as u64)
    });
    MachineChannel { id: data.id, recorded: recorded.collect() }
}

fn found(machine: &MachineChannel, known: Option<&[Extended]>) -> Findings {
    let channels = [machine.clone()];
    let base = match known {
        Some(models) => known_base(machine, &models[0], &|| ()),
        None => fit_base(machine, &|| ()),
    };
    find(&channels, vec![base.expect("the base model runs")], known, STRUCTURE, &|_, _| {})
}

fn named(findings: &Findings) -> Vec<&'static str> {
    findings.causes.iter().map(|cause| CATALOGUE[cause.effect].id).collect()
}

fn size(findings: &Findings, recording: usize, name: &str) -> (f64, Option<[f64; 2]>) {
    let estimate = &findings.sizes[0].loads[recording][name];
    (estimate.value, estimate.ci95)
}

const VOLUMES: [f64; 5] = [1.0, 0.6, 1.4, 0.8, 1.0];

#[test]
fn a_sound_machine_is_given_no_name_and_its_volumes_are_told() {
    let findings = found(&machine(&VOLUMES, &[]), None);
    assert_eq!(named(&findings), [""; 0]);
    let nothing = findings.candidates.iter().find(|(c, _)| c.missing == Missing::Nothing);
    assert!(nothing.is_some());
    for (recording, volume) in VOLUMES.iter().enumerate().skip(1) {
        let (value, ci95) = size(&findings, recording, "chamber_volume.ratio");
        assert!((value / volume - 1.0).abs() < 0.02, "{value} {volume}");
        let [low, high] = ci95.expect("it is determined");
        assert!(low < *volume && *volume < high && high / low < 1.2, "{low} {volume} {high}");
    }
}

#[test]
fn a_tube_in_every_load_is_named_with_a_size_of_its_own_and_serves_a_recording_that_was_not_there() {
    let tubes_s = [0.05, 0.1, 0.2, 0.4, 0.1];
    let all = machine(&VOLUMES, &tubes_s);
    let findings = found(&all.without(4), None);
    assert_eq!(named(&findings), ["line_restriction"]);
    let cause = &findings.causes[0];
    assert!(cause.probability > 0.99 && cause.equivalent.is_empty(), "{cause:?}");
    assert!(cause.gain.ci95[0] > 0.2, "{:?}", cause.gain);
    for (recording, tube_s) in tubes_s.iter().enumerate().take(4) {
        let (value, _) = size(&findings, recording, "line_restriction.time_constant");
        assert!((value / tube_s - 1.0).abs() < 0.1, "{value} {tube_s}");
    }
    // The last recording with the machine of the others.
    let known = [findings.sizes[0].models.models[0].clone()];
    let alone = found(&all.only(4), Some(&known));
    assert_eq!(named(&alone), ["line_restriction"]);
    let (value, _) = size(&alone, 0, "line_restriction.time_constant");
    assert!((value / tubes_s[4] - 1.0).abs() < 0.1, "{value}");
    let (volume, _) = size(&alone, 0, "chamber_volume.ratio");
    assert!((volume / VOLUMES[4] - 1.0).abs() < 0.02, "{volume}");
}

#[test]
fn whether_loads_differ_is_found_out() {
    for (volumes, expected) in [([1.0; 5], false), (VOLUMES, true)] {
        let machine = machine(&volumes, &[]);
        let base = fit_base(&machine, &|| ()).expect("the base model runs");
        assert_eq!(differ(&[machine], &[base]), expected, "{volumes:?}");
    }
}

#[test]
fn only_what_is_asked_about_is_looked_for() {
    let channels = [machine(&[1.0, 0.5], &[])];
    let [tube, sag] = ["line_restriction", "supply_sag"].map(|id| index_of(id).unwrap());
    let ripple = index_of("supply_ripple").unwrap();
    let only = |effects: &[usize]| possible(&channels, Asked { only: effects, ..STRUCTURE });
    assert_eq!(only(&[tube, ripple]), [tube], "a cycle has no sizes to be tried");
    assert!(only(&[]).contains(&tube) && only(&[]).contains(&sag));
}
