//! How finely channels are simulated: coarsely while causes are looked for, as finely as needed for
//! what is reported.

use std::borrow::Cow;

use super::data::ChannelData;
use crate::effects::catalogue::CATALOGUE;
use crate::effects::{BoardLoop, DriveInput, Plant};

/// Longest integration step of what is reported, s. It is checked against half of it.
pub const LONGEST_STEP_S: f64 = 0.0025;
/// Longest integration step while causes are looked for, s.
const SEARCH_STEP_S: f64 = 0.01;
/// Longest step of the board's loop while causes are looked for, s. A board's loop is much faster
/// than a chamber: several loops are simulated as one, and only what is reported is fitted and
/// judged with every one of them.
const SEARCH_LOOP_S: f64 = 0.005;
/// The same of models with effects that make the chamber
/// [as fast](crate::effects::Trait::FastInLoop).
const FAST_LOOP_S: f64 = 0.0025;

/// Simulates as coarsely as the search for causes may, or as finely as what is reported needs.
pub fn simulate_coarsely(channels: &mut [ChannelData], coarsely: bool) {
    for data in channels {
        data.plant.longest_step_s = if coarsely { SEARCH_STEP_S } else { LONGEST_STEP_S };
        if let Some(board) = &mut data.plant.board {
            board.loops_per_step = if coarsely { loops_in(board, SEARCH_LOOP_S) } else { 1 };
        }
    }
}

/// The steps in which a channel is simulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steps {
    longest_s: f64,
    loops: usize,
}

impl ChannelData {
    /// The steps in which it is simulated.
    #[must_use]
    pub fn steps(&self) -> Steps {
        let loops = self.plant.board.as_ref().map_or(0, |board| board.loops_per_step);
        Steps { longest_s: self.plant.longest_step_s, loops }
    }

    /// The channel in coarser steps of the board's loop, where there are any.
    #[must_use]
    pub fn rough(&self) -> Cow<'_, Self> {
        rougher(self).map_or(Cow::Borrowed(self), Cow::Owned)
    }

    /// The plant in steps that are short enough for a model with these effects.
    #[must_use]
    pub fn plant_with(&self, effects: &[usize]) -> Cow<'_, Plant> {
        let fast = effects.iter().any(|&effect| CATALOGUE[effect].is_fast_in_loop());
        let board = self.plant.board.as_ref().filter(|_| fast && self.inputs.in_loop());
        let Some(board) = board.filter(|board| board.loops_per_step > loops_in(board, FAST_LOOP_S)) else {
            return Cow::Borrowed(&self.plant);
        };
        let board = BoardLoop { loops_per_step: loops_in(board, FAST_LOOP_S), ..*board };
        Cow::Owned(Plant { board: Some(board), ..self.plant.clone() })
    }
}

/// The channel in the steps of the search, where the board's loop is simulated and they are longer
/// than its own.
fn rougher(data: &ChannelData) -> Option<ChannelData> {
    let board = data.plant.board.as_ref().filter(|_| data.inputs.drive == DriveInput::Controlled)?;
    let loops = loops_in(board, SEARCH_LOOP_S);
    if loops <= board.loops_per_step {
        return None;
    }
    let mut rough = data.clone();
    rough.plant.board = Some(BoardLoop { loops_per_step: loops, ..*board });
    Some(rough)
}

/// Whole loops of a board in a time, at least one.
// At least one, and a rate is below 1e9.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn loops_in(board: &BoardLoop, time_s: f64) -> usize {
    (time_s * board.rate_hz * (1.0 + 1e-9)).max(1.0) as usize
}

/// Halves the integration step where drives are recorded; `false` when it is as fine as what is
/// reported.
pub fn simulate_finer(channels: &mut [ChannelData]) -> bool {
    let mut finer = false;
    for data in channels {
        let next = (0.5 * data.plant.longest_step_s).max(LONGEST_STEP_S);
        if data.inputs.drive != DriveInput::Controlled && next < data.plant.longest_step_s {
            data.plant.longest_step_s = next;
            finer = true;
        }
    }
    finer
}

/// The channel with half the integration step. A board's loop keeps its rate; the integration
/// within each loop is refined.
#[must_use]
pub fn halved(data: &ChannelData) -> ChannelData {
    let mut finer = data.clone();
    let step_s = match &data.plant.board {
        Some(board) if data.inputs.drive == DriveInput::Controlled => {
            data.plant.longest_step_s.min(board.loops_per_step as f64 / board.rate_hz)
        }
        _ => data.plant.longest_step_s,
    };
    finer.plant.longest_step_s = 0.5 * step_s;
    finer
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::channel;
    use crate::effects::catalogue::index_of;
    use crate::effects::{Domain, EffectInfo};

    /// Part of the noise's variance that the steps of a search may leave.
    const MOST_LEFT: f64 = 0.02;
    /// The same with a tube, whose pressures move within milliseconds.
    const MOST_LEFT_WITH_TUBE: f64 = 0.4;

    #[test]
    fn steps_of_a_search_leave_little_of_the_noise_with_any_effect_that_lets_a_loop_rest() {
        let (data, base) = channel(true);
        let mut coarse = [data.clone()];
        simulate_coarsely(&mut coarse, true);
        assert!(coarse[0].steps() != data.steps());
        let among = |info: &&EffectInfo| info.domain != Domain::Regulator && !info.makes_limit_cycles();
        for info in CATALOGUE.iter().copied().filter(among) {
            let effect = index_of(info.id).unwrap();
            for probe in info.probes {
                let model = base.with(&data.plant, effect, probe);
                let readings = [&data, &coarse[0]].map(|data| data.readings(&model));
                let squares = readings[0].iter().zip(&readings[1]).map(|(a, b)| (a - b).powi(2));
                let left = squares.sum::<f64>() / readings[0].len() as f64 / data.noise_kpa.powi(2);
                let tube = info.id == "line_restriction";
                let most = if tube { MOST_LEFT_WITH_TUBE } else { MOST_LEFT };
                assert!(left < most, "{} {probe:?}: {left}", info.id);
            }
        }
    }
}
