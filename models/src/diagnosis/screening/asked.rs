//! What is asked of a recording, and of which effects.

use crate::diagnosis::channel::ChannelData;
use crate::diagnosis::error::DiagnosisError;
use crate::effects::catalogue::CATALOGUE;
use crate::effects::{Domain, Question};

/// What is missing, or what has changed, and which effects it may be.
#[derive(Debug, Clone, Copy)]
pub struct Asked<'a> {
    /// The question.
    pub question: Question,
    /// Numbers of the effects that it may be; empty: any of the catalogue. What is outside the
    /// catalogue competes in any case.
    pub only: &'a [usize],
}

impl Asked<'_> {
    /// Is an effect one of them?
    #[must_use]
    pub fn is_among(&self, effect: usize) -> bool {
        self.only.is_empty() || self.only.contains(&effect)
    }

    /// Is an effect of this channel in question, or outside the catalogue?
    #[must_use]
    pub fn is_about(&self, data: &ChannelData, effect: usize) -> bool {
        let competes = CATALOGUE[effect].question == Question::Foil;
        (competes || self.is_among(effect)) && applicable(data, effect, self.question)
    }

    /// Refuses effects that no channel can be asked about: silence about them would say nothing.
    ///
    /// # Errors
    /// [`DiagnosisError::NotInQuestion`] for the first of them.
    pub fn check(&self, file: &str, channels: &[ChannelData]) -> Result<(), DiagnosisError> {
        let unknown =
            |effect: &&usize| !channels.iter().any(|data| applicable(data, **effect, self.question));
        let Some(&effect) = self.only.iter().find(unknown) else { return Ok(()) };
        let why = if !channels.iter().any(|data| is_of_kind(data, effect)) {
            "it is no effect of what these channels are (valve or regulator)"
        } else if channels.iter().all(|data| !CATALOGUE[effect].is_known(&data.inputs)) {
            "this recording does not hold what it depends on, such as the pressures of other channels"
        } else if self.question == Question::Change {
            "it is asked about without a calibrated model"
        } else {
            "it is asked about against a calibrated model of the same rig"
        };
        Err(DiagnosisError::NotInQuestion { file: file.to_owned(), effect: CATALOGUE[effect].id, why })
    }
}

/// Can this effect be asked about on this channel?
#[must_use]
pub fn applicable(data: &ChannelData, effect: usize, question: Question) -> bool {
    let info = CATALOGUE[effect];
    // A regulator's base model has no parameters of its parts: what has changed in it is an effect
    // that was not there.
    let asked = info.question == question
        || (info.question == Question::Foil && question == Question::Structure)
        || data.plant.model.is_regulator();
    is_of_kind(data, effect) && info.is_known(&data.inputs) && asked
}

/// Is it an effect of such a plant?
fn is_of_kind(data: &ChannelData, effect: usize) -> bool {
    let other = if data.plant.model.is_regulator() { Domain::Valve } else { Domain::Regulator };
    CATALOGUE[effect].domain != other
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::{STRUCTURE, channel};
    use crate::effects::catalogue::index_of;

    fn number(id: &str) -> usize {
        index_of(id).unwrap()
    }

    #[test]
    fn what_is_not_among_those_asked_about_is_not_tried_and_what_is_outside_the_catalogue_is() {
        let (data, _) = channel(false);
        let only = [number("valve_lag")];
        let asked = Asked { question: Question::Structure, only: &only };
        assert!(asked.is_about(&data, number("valve_lag")) && !asked.is_about(&data, number("wall_creep")));
        assert!(asked.is_about(&data, number("coil_heating")), "competes");
        assert!(STRUCTURE.is_about(&data, number("wall_creep")));
    }

    #[test]
    fn a_wrong_statement_of_the_supply_is_suspected_only_where_it_is_not_measured() {
        let (mut data, _) = channel(true);
        let misstated = number("supply_misstated");
        assert!(applicable(&data, misstated, Question::Structure));
        assert!(!applicable(&data, misstated, Question::Change), "a reference has been calibrated with it");
        data.inputs.supply_pa = data.inputs.supply_pa.iter().enumerate().map(|(k, p)| p + k as f64).collect();
        assert!(!applicable(&data, misstated, Question::Structure));
    }

    #[test]
    fn what_cannot_be_asked_about_is_refused_with_the_reason() {
        let (mut data, _) = channel(false);
        data.inputs.opposite_pa = Vec::new().into();
        let refused = |id: &str, question| {
            let only = [number("valve_lag"), number(id)];
            let error = Asked { question, only: &only }.check("run.csv", std::slice::from_ref(&data));
            error.err().map(|e| e.to_string()).unwrap_or_default()
        };
        assert_eq!(refused("wall_creep", Question::Structure), "");
        assert!(refused("chamber_coupling", Question::Structure).contains("other channels"));
        assert!(refused("rate_limit", Question::Structure).contains("valve or regulator"));
        assert!(refused("exhaust_leak", Question::Structure).contains("against a calibrated model"));
        assert!(refused("wall_creep", Question::Change).contains("valve_lag cannot be asked about"));
    }
}
