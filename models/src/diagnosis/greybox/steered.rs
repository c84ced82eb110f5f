//! Prediction errors of several models side by side, with the gains that a filter took.
//!
//! What a small change of a parameter does to the errors, but for what it does to the gains: the
//! usual derivatives of a prediction error method where the gain is given (L. Ljung, System
//! Identification, 1999, section 10.3). It takes plain simulations in lanes, where the filter takes
//! one with derivatives for every model.

use super::filter::{Gains, SLOW, kept};
use crate::diagnosis::channel::{ChannelData, Extended};
use crate::effects::{Memory, Stepper, install};
use crate::numeric::{Lanes, Scalar};

/// Models in one simulation.
pub const LANES: usize = 4;

/// Prediction errors of the counted rows, Pa, of one to [`LANES`] models with the same effects.
#[must_use]
pub fn steered_errors(
    data: &ChannelData,
    models: &[Extended],
    gains: &Gains,
    counted: &[bool],
) -> Vec<Vec<f64>> {
    let inputs = &data.inputs;
    // Lanes that are not needed repeat the last one.
    let of = |lane: usize| &models[lane.min(models.len() - 1)].values;
    let values: Vec<Lanes<LANES>> =
        (0..of(0).len()).map(|p| Lanes(std::array::from_fn(|lane| of(lane)[p]))).collect();
    let mut effects = install(&data.plant, &models[0].effects, &values);
    let mut simulation = Stepper::new(&data.plant, &values, &mut effects, inputs);
    let mut errors = vec![Vec::with_capacity(gains.most_pa.len()); models.len()];
    let mut slow = [Lanes::zero(); SLOW];
    let mut next_start = inputs.starts.iter().peekable();
    let rows = gains.by_error.chunks_exact(gains.state.max(1)).zip(&gains.most_pa);
    for (row, (gain, &most)) in rows.enumerate() {
        if next_start.next_if_eq(&&row).is_some() {
            simulation.start(row);
            slow = [Lanes::zero(); SLOW];
        } else {
            let reading = simulation.reading(row) + slow[1];
            if inputs.usable[row] {
                let error = (-reading).plus(inputs.measured_pa[row] - inputs.ambient_pa);
                if counted[row] {
                    for lane in 0..models.len() {
                        errors[lane].push(error.0[lane]);
                    }
                }
                let mut pull = error;
                for lane in 0..LANES {
                    pull.0[lane] = error.0[lane].clamp(-most, most);
                }
                let (of_memory, of_slow) = gain.split_at(gain.len() - SLOW);
                let mut of_memory = of_memory.iter();
                simulation.memory(&mut |memory, value| {
                    if memory == Memory::Estimated
                        && let Some(&by_error) = of_memory.next()
                    {
                        *value = *value + pull.times(by_error);
                    }
                });
                for k in 0..SLOW {
                    slow[k] = slow[k] + pull.times(of_slow[k]);
                }
            }
        }
        simulation.set_supply(slow[0].plus(1.0).times(inputs.supply_pa[row]));
        simulation.interval(row);
        for (value, keep) in slow.iter_mut().zip(kept(inputs.interval_s[row])) {
            *value = value.times(keep);
        }
    }
    errors
}
