//! What was found about a machine, as `report.json` has it.

use std::collections::BTreeMap;
use std::path::Path;

use super::recordings::MachineChannel;
use super::search::{Findings, NamedCause};
use super::ties::TiedModel;
use crate::data::Recording;
use crate::diagnosis::channel::{ChannelData, Extended, Role, compared_rows, halved, rows_of, split};
use crate::diagnosis::discrepancy::{adequacy, dependences, significant};
use crate::diagnosis::estimation::{ChannelStage, free_of};
use crate::diagnosis::inference::band::Band;
use crate::diagnosis::json::{
    Alternative, Baseline, BaselineChannel, Cause, Checks, Data, Estimate, MachineRecord, MachineReport,
    Report, SCHEMA, Symptom, Unexplained, Verdict,
};
use crate::diagnosis::preconditions::much_missing;
use crate::diagnosis::report::alternatives::listed;
use crate::diagnosis::report::{ExtendedFile, band_holds, extended_file};
use crate::diagnosis::settings;
use crate::effects::catalogue::CATALOGUE;
use crate::rig::Rig;

/// What a report is made of.
pub(super) struct Found<'a> {
    pub channels: &'a [MachineChannel],
    pub findings: &'a Findings,
    pub recordings: &'a [Recording],
    /// Files of the recordings.
    pub names: &'a [String],
}

/// Estimates by name.
type Sizes = BTreeMap<String, Estimate>;

impl Found<'_> {
    /// The report, in which these effects were in question, or all where it is none.
    pub fn report(&self, notes: Vec<String>, only: &[usize]) -> Report {
        let [before, after] = &self.findings.held_out;
        let recorded: Vec<&ChannelData> = self.channels.iter().flat_map(|c| &c.recorded).collect();
        let noise_kpa =
            (recorded.iter().map(|d| d.noise_kpa.powi(2)).sum::<f64>() / recorded.len() as f64).sqrt();
        let (left, allowed_kpa, halved_kpa) = self.rest();
        let left_kpa = after.rmse_kpa();
        let rest = !left.is_empty() || adequacy::beyond(left_kpa, allowed_kpa);
        let square = |kpa: f64| (kpa * kpa - noise_kpa * noise_kpa).max(0.0);
        let mut report = Report {
            schema: SCHEMA.to_owned(),
            data: self.data(),
            verdict: Verdict::new(!self.findings.causes.is_empty(), rest),
            sentence: String::new(),
            baseline: self.baseline(before.rmse_kpa(), noise_kpa),
            symptoms: Vec::new(),
            causes: self.findings.causes.iter().map(|cause| self.cause(cause)).collect(),
            imperfections: Vec::new(),
            unexplained: Unexplained {
                share: square(left_kpa) / square(before.rmse_kpa()).max(f64::MIN_POSITIVE),
                test_rmse_kpa: left_kpa,
                correction: None,
                depends_on: left,
                withheld: None,
            },
            next_experiment: None,
            extended_model: Some(file_of(self.names, 0)),
            notes,
            checks: Checks {
                allowed_rmse_kpa: allowed_kpa,
                halved_step_rms_kpa: halved_kpa,
                blocks: [1; 3],
                block_s: self.recordings.iter().map(Recording::duration_s).fold(0.0, f64::max) / 3.0,
                band_holds: None,
            },
            settings: settings::list().into_iter().map(|s| (s.name.to_owned(), s.value)).collect(),
            alternatives: self.alternatives(),
            machine: Some(self.machine()),
            asked: only.iter().map(|&effect| CATALOGUE[effect].id.to_owned()).collect(),
        };
        report.sentence = self.sentence(&report) + &much_missing(recorded);
        report
    }

    /// The extended model of each recording, with its file's name.
    pub fn extended(&self, rig: &Rig) -> Vec<(String, ExtendedFile)> {
        let one = |r: usize| {
            let (data, models) = self.recorded(r);
            let mut file = extended_file(&data, &models, rig);
            // The final models were fitted to the parts where causes are chosen, too: errors there
            // say little about other rows.
            for (data, chosen) in data.iter().zip(&self.findings.last().models) {
                if let Some(channel) = file.channels.get_mut(&data.id.to_string()) {
                    channel.band = Band::of(data, &chosen.models[r]);
                }
            }
            (file_of(self.names, r), file)
        };
        (0..self.names.len()).map(one).collect()
    }

    /// Share of the readings of the last parts that the bands of these models hold.
    pub fn band_holds(&self, extended: &[(String, ExtendedFile)]) -> Option<f64> {
        let recorded: Vec<_> = (0..extended.len()).map(|r| self.recorded(r)).collect();
        let all = recorded.iter().zip(extended);
        band_holds(all.map(|((data, models), (_, file))| (&data[..], &models[..], file)))
    }

    /// The channels of a recording with their final models.
    fn recorded(&self, r: usize) -> (Vec<ChannelData>, Vec<Extended>) {
        let data = self.channels.iter().map(|c| c.recorded[r].clone()).collect();
        (data, self.findings.sizes.iter().map(|s| s.models.models[r].clone()).collect())
    }

    fn data(&self) -> Data {
        Data {
            file: self.names.join(", "),
            rows: self.recordings.iter().map(Recording::rows).sum(),
            rate_hz: self.recordings[0].rate_hz(),
            seconds: self.recordings.iter().map(Recording::duration_s).sum(),
        }
    }

    fn baseline(&self, test_rmse_kpa: f64, noise_floor_kpa: f64) -> Baseline {
        let model = self.channels[0].recorded[0].plant.model.name().to_owned();
        let one = |(channel, models): (&MachineChannel, &TiedModel)| {
            let names = channel.recorded[0].plant.parameters();
            let parameters = names.into_iter().zip(&models.models[0].values).map(|(p, v)| (p.name, *v));
            (channel.id.to_string(), BaselineChannel { parameters: parameters.collect(), test_rmse_kpa })
        };
        let channels = self.channels.iter().zip(&self.findings.base.models).map(one).collect();
        Baseline { model, test_rmse_kpa, noise_floor_kpa, channels }
    }

    fn cause(&self, named: &NamedCause) -> Cause {
        let info = CATALOGUE[named.effect];
        let prefix = format!("{}.", info.id);
        let own = |sizes: &Sizes| -> Sizes {
            let of = sizes.iter().filter_map(|(name, e)| Some((name.strip_prefix(&prefix)?, e)));
            of.map(|(name, e)| (name.to_owned(), e.clone())).collect()
        };
        let acting = || self.channels.iter().zip(&self.findings.sizes).zip(&named.acts).filter(|(_, a)| **a);
        let mut by_channel = BTreeMap::new();
        for ((channel, sizes), _) in acting() {
            for (name, load) in self.names.iter().zip(&sizes.loads) {
                by_channel.insert(self.place(name, channel), own(load));
            }
        }
        let first = acting().next();
        Cause {
            effect: info.id.to_owned(),
            channels: acting().map(|((channel, _), _)| channel.id.to_string()).collect(),
            equivalent: named.equivalent.iter().map(|&e| CATALOGUE[e].id.to_owned()).collect(),
            parameters: first.map_or_else(BTreeMap::new, |((_, sizes), _)| own(&sizes.machine)),
            by_channel,
            p_value: 1.0 - named.probability,
            probability: Some(named.probability),
            gain: named.gain.clone(),
        }
    }

    /// A recording and, where there are several, a channel.
    fn place(&self, name: &str, channel: &MachineChannel) -> String {
        match self.channels.len() {
            1 => short(name),
            _ => format!("{} {}", short(name), channel.id),
        }
    }

    fn alternatives(&self) -> Vec<Alternative> {
        let all = self.findings.candidates.iter();
        listed(all.map(|(candidate, p)| (&candidate.missing, *p, candidate.evidence.rmse_kpa())))
    }

    fn machine(&self) -> MachineReport {
        let [before, after] = &self.findings.held_out;
        let pieces = after.units.len() / self.names.len().max(1);
        let rmse = |units: &[(f64, f64)]| {
            let (sum, count) = units.iter().fold((0.0, 0.0), |a, u| (a.0 + u.0, a.1 + u.1));
            (sum / f64::max(count, 1.0)).sqrt()
        };
        let count = self.names.len();
        let discrepancy = |all: &[f64], r: usize| -> f64 {
            let own = all.chunks(count).filter_map(|channel| channel.get(r));
            own.copied().fold(0.0, f64::max)
        };
        let last = self.findings.last();
        let record = |(r, name): (usize, &String)| MachineRecord {
            file: name.clone(),
            test_rmse_before_kpa: rmse(&before.units[r * pieces..(r + 1) * pieces]),
            test_rmse_after_kpa: rmse(&after.units[r * pieces..(r + 1) * pieces]),
            discrepancy_before_kpa: discrepancy(&self.findings.base.evidence.discrepancy_kpa, r),
            discrepancy_after_kpa: discrepancy(&last.evidence.discrepancy_kpa, r),
            load: self
                .channels
                .iter()
                .zip(&self.findings.sizes)
                .map(|(channel, sizes)| (channel.id.to_string(), sizes.loads[r].clone()))
                .collect(),
            extended_model: file_of(self.names, r),
        };
        let bases = self.findings.base.models.iter();
        let finals = self.findings.sizes.iter().map(|s| &s.models);
        MachineReport {
            known: self.findings.known,
            joint_rmse_before_kpa: joint_rmse_kpa(self.channels.iter().zip(bases)),
            joint_rmse_after_kpa: joint_rmse_kpa(self.channels.iter().zip(finals)),
            recordings: self.names.iter().enumerate().map(record).collect(),
        }
    }

    /// What the residual of the final models depends on, what error is allowed, and what half the
    /// integration step changes, kPa.
    fn rest(&self) -> (Vec<Symptom>, f64, f64) {
        let mut data: Vec<ChannelData> = Vec::new();
        let mut models: Vec<Extended> = Vec::new();
        let (mut changed, mut rows) = (0.0, 0.0_f64);
        for (channel, sizes) in self.channels.iter().zip(&self.findings.sizes) {
            for (recorded, model) in channel.recorded.iter().zip(&sizes.models.models) {
                for (a, b) in recorded.readings(model).iter().zip(halved(recorded).readings(model)) {
                    changed += (a - b).powi(2);
                    rows += 1.0;
                }
                data.push(interleaved(recorded));
                models.push(model.clone());
            }
        }
        let stages: Vec<ChannelStage> = data
            .iter()
            .zip(&models)
            .map(|(data, model)| ChannelStage::new(data, model.clone(), free_of(data, model, false)))
            .collect();
        let left = significant(&data, &dependences(&data, &stages));
        (left, adequacy::allowed_kpa(&data, &models), (changed / rows.max(1.0)).sqrt())
    }
}

/// RMS error of rollouts over the last parts of the recordings, kPa.
fn joint_rmse_kpa<'a>(all: impl Iterator<Item = (&'a MachineChannel, &'a TiedModel)>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for (channel, models) in all {
        for (data, model) in channel.recorded.iter().zip(&models.models) {
            let residuals = data.residuals(model);
            for row in rows_of(data, &[Role::Test]) {
                sum += residuals[row].powi(2);
                count += 1.0;
            }
        }
    }
    (sum / count.max(1.0)).sqrt()
}

/// The same channel in the blocks of a recording that is alone, whose dependences are tested from
/// block to block.
fn interleaved(data: &ChannelData) -> ChannelData {
    let mut cut = data.clone();
    cut.blocks = split(&cut.inputs);
    let (rows, spans) = compared_rows(&cut.inputs, &cut.blocks);
    let kpa = |&row: &u32| (cut.inputs.measured_pa[row as usize] - cut.inputs.ambient_pa) * 1e-3;
    cut.measured_kpa = rows.iter().map(kpa).collect();
    (cut.rows, cut.spans) = (rows, spans);
    cut
}

/// Name of a file without its folder.
pub(super) fn short(name: &str) -> String {
    Path::new(name).file_name().map_or_else(|| name.to_owned(), |file| file.to_string_lossy().into_owned())
}

/// File of a recording's extended model: `extended.toml` of one, `extended-NAME.toml` of several;
/// numbered where names are alike.
fn file_of(names: &[String], recording: usize) -> String {
    if names.len() == 1 {
        return crate::diagnosis::run::EXTENDED_FILE.to_owned();
    }
    let stem = |name: &String| {
        let short = short(name);
        short.split('.').next().unwrap_or_default().to_owned()
    };
    let own = stem(&names[recording]);
    let alike = names.iter().filter(|name| stem(name) == own).count();
    if alike > 1 { format!("extended-{own}-{}.toml", recording + 1) } else { format!("extended-{own}.toml") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_recording_has_a_file_of_its_own() {
        let names = |list: &[&str]| list.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
        assert_eq!(file_of(&names(&["a/run.csv"]), 0), "extended.toml");
        let several = names(&["a/run1.csv.zst", "a/run2.csv"]);
        assert_eq!([0, 1].map(|k| file_of(&several, k)), ["extended-run1.toml", "extended-run2.toml"]);
        let alike = names(&["a/run.csv", "b/run.csv"]);
        assert_eq!([0, 1].map(|k| file_of(&alike, k)), ["extended-run-1.toml", "extended-run-2.toml"]);
    }
}
