//! Cycles of the supply, searched for by their period.

use crate::order::descending;
use nalgebra::{Matrix2, Vector2};

use super::periodogram::{Heard, Listener};
use super::scores::{CLIP, DRAWS};
use crate::diagnosis::channel::ChannelData;
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::resampling::{generator, quantile, signs};
use crate::effects::Wave;
use crate::parallel;

/// Shortest period looked for, s.
const SHORTEST_S: f64 = 1.5;
/// Frequencies looked at, at most, from the lowest: in an hour's recording the fastest cycles are
/// left out.
const MOST: usize = 160;
/// Distance of neighbouring frequencies, periods per recording.
const SPACING: f64 = 0.8;
/// Periods that a recording has of a cycle at least: what came once or twice may not come back.
const PERIODS: f64 = 3.0;
/// Peaks of the periodogram that are followed; blocks of a few seconds show a cycle at other
/// frequencies, too.
const PEAKS: usize = 5;
/// Distance of the frequencies at which a peak is looked at closely, periods per recording: a tenth
/// of a period at the end leaves nearly all of a cycle.
const CLOSELY: f64 = 0.1;

/// What a search for cycles finds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cycles {
    /// The strongest, strongest first.
    pub waves: Vec<Wave>,
    /// How far they stand out of what chance finds.
    pub search: Search,
}

/// How far what a search found stands out of what the same search finds by chance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Length of the sum of scores in their standard deviations, the largest of all that was tried.
    pub statistic: f64,
    /// Share of random-sign draws that reach it.
    pub p_value: f64,
}

impl Default for Search {
    fn default() -> Self {
        Self { statistic: 0.0, p_value: 1.0 }
    }
}

/// The strongest cycles on the open blocks of all channels, which have one supply: the same part of
/// its pressure in all of them.
///
/// What chance finds in as many frequencies is found out by repeating the search under random signs
/// of the quarters of blocks, as the gate does with the catalogue.
#[must_use]
pub fn strongest_cycles(channels: &[ChannelData], stages: &[ChannelStage]) -> Cycles {
    let valves = || channels.iter().zip(stages).filter(|(data, _)| !data.plant.model.is_regulator());
    let duration = valves().map(|(data, _)| data.inputs.duration_s).fold(1.0, f64::max);
    let lowest = PERIODS / duration;
    let count = (((1.0 / SHORTEST_S) - lowest) / (SPACING / duration)).max(1.0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at least one
    let count = (count as usize).min(MOST);
    let frequencies: Vec<f64> = (0..count).map(|k| lowest + SPACING / duration * k as f64).collect();
    let listeners = parallel::map(valves(), |(data, stage)| Listener::new(data, stage, &frequencies));
    let heard = parallel::map(frequencies, |frequency| Heard::new(&listeners, frequency));
    let closely = |peak: f64| {
        #[allow(clippy::cast_possible_truncation)] // a few
        let steps = (0.5 * SPACING / CLOSELY) as i32;
        let near = (-steps..=steps).map(|k| Heard::new(&listeners, peak + CLOSELY / duration * f64::from(k)));
        near.max_by(|a, b| a.gain.total_cmp(&b.gain)).and_then(|heard| heard.wave)
    };
    let waves =
        parallel::map(peaks(&heard, 1.5 * SPACING / duration), closely).into_iter().flatten().collect();
    Cycles { waves, search: by_chance(&heard) }
}

/// Frequencies of the strongest waves that are so far apart, Hz, strongest first.
fn peaks(heard: &[Heard], apart_hz: f64) -> Vec<f64> {
    let mut ranked: Vec<&Heard> = heard.iter().filter(|heard| heard.wave.is_some()).collect();
    descending(&mut ranked, |item| item.gain);
    let mut peaks: Vec<f64> = Vec::new();
    for Heard { frequency_hz, .. } in ranked {
        if peaks.len() < PEAKS && peaks.iter().all(|f| (f - frequency_hz).abs() > apart_hz) {
            peaks.push(*frequency_hz);
        }
    }
    peaks
}

/// The largest statistic over the frequencies, and how often random signs reach it.
fn by_chance(heard: &[Heard]) -> Search {
    let tests: Vec<Vec<Vector2<f64>>> = heard.iter().map(|h| orthonormal(&h.parts)).collect();
    let length = tests.iter().map(Vec::len).max().unwrap_or(0);
    let largest = |signs: &[f64]| {
        let statistic = |parts: &Vec<Vector2<f64>>| {
            parts.iter().zip(signs).map(|(part, sign)| part * *sign).sum::<Vector2<f64>>().norm()
        };
        tests.iter().map(statistic).fold(0.0, f64::max)
    };
    let observed = largest(&vec![1.0; length]);
    let mut rng = generator(1);
    let drawn: Vec<Vec<f64>> = (0..DRAWS).map(|_| signs(&mut rng, length)).collect();
    let reached = parallel::map(drawn.iter(), |s| largest(s) >= observed).into_iter().filter(|r| *r).count();
    Search { statistic: observed, p_value: (reached + 1) as f64 / (DRAWS + 1) as f64 }
}

/// Scores of the parts of blocks, clipped and scaled to the identity as the sum of their squares;
/// none where they have one direction only.
fn orthonormal(parts: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
    let mut sizes: Vec<f64> = parts.iter().map(|z| z.norm()).filter(|size| *size > 0.0).collect();
    sizes.sort_by(f64::total_cmp);
    let most = if sizes.is_empty() { 0.0 } else { CLIP * quantile(&sizes, 0.75) };
    let clipped: Vec<Vector2<f64>> = parts.iter().map(|z| z.cap_magnitude(most)).collect();
    let square: Matrix2<f64> = clipped.iter().map(|z| z * z.transpose()).sum();
    let Some(root) = square.cholesky() else { return Vec::new() };
    clipped.iter().filter_map(|z| root.l().solve_lower_triangular(z)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::{channel, measured, with};

    /// What is found where the supply of two channels cycles by this much, kPa, every 3 s, from
    /// these phases on.
    fn found(amplitude_kpa: f64, phases: [f64; 2]) -> Cycles {
        let (data, base) = channel(false);
        let channels = phases.map(|phase| {
            let model = with(&data, &base, "supply_ripple", &[amplitude_kpa, 3.0, phase, 0.3]);
            let seed = if phase > 0.3 { 5 } else { 6 };
            measured(data.clone(), &model, seed)
        });
        let stages = channels.each_ref().map(|data| ChannelStage::new(data, base.clone(), (0..7).collect()));
        strongest_cycles(&channels, &stages)
    }

    #[test]
    fn a_cycle_of_the_common_supply_is_found_with_its_period_and_stands_out_of_chance() {
        let Cycles { waves, search } = found(40.0, [0.2; 2]);
        assert_eq!(waves.len(), PEAKS);
        let period_s = waves[0].period_s();
        assert!((period_s - 3.0).abs() < 0.1, "{period_s}");
        // A triangle's first harmonic.
        let amplitude_kpa = waves[0].share() * waves[0].gauge_pa * 1e-3;
        assert!((25.0..45.0).contains(&amplitude_kpa), "{amplitude_kpa}");
        assert!(search.p_value < 0.01, "{search:?}");
    }

    #[test]
    fn noise_has_cycles_too_and_they_do_not_stand_out() {
        let Cycles { waves, search } = found(0.0, [0.2, 0.7]);
        assert_eq!(waves.len(), PEAKS);
        assert!(search.p_value > 0.05, "{search:?}");
    }

    #[test]
    fn what_cycles_in_two_channels_one_against_the_other_is_not_their_supply() {
        let common = found(40.0, [0.2; 2]);
        let against = found(40.0, [0.2, 0.7]);
        let largest = |cycles: &Cycles| cycles.waves.iter().map(Wave::share).fold(0.0, f64::max);
        assert!(largest(&against) < 0.3 * largest(&common), "{against:?} {common:?}");
    }
}
