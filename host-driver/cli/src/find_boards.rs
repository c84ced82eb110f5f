use pneudrive_host::bus::{Bus, ExchangeError};
use pneudrive_host::line::Line;
use thiserror::Error;

/// Nobody is there.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("none of the {devices} board(s) answered within {waited_s} s; the last try said: {last}")]
pub struct NoBoards {
    pub devices: usize,
    pub waited_s: f64,
    pub last: ExchangeError,
}

/// Pings `boards` until all have answered or the time is up: a single lost packet does not matter.
/// Returns those that did not answer, with what their last try said.
pub fn find<L: Line>(
    bus: &mut Bus<L>,
    boards: &[u8],
    wait_s: f64,
    stop: impl Fn() -> bool,
) -> Result<Vec<(u8, ExchangeError)>, NoBoards> {
    let deadline = bus.line().now_ns() + (wait_s * 1e9) as u64;
    let mut silent: Vec<(u8, Option<ExchangeError>)> = boards.iter().map(|&board| (board, None)).collect();
    while !silent.is_empty() && bus.line().now_ns() < deadline && !stop() {
        silent.retain_mut(|(board, error)| {
            *error = bus.ping(*board).err();
            error.is_some()
        });
        if silent.iter().any(|(_, error)| matches!(error, Some(ExchangeError::Line(_)))) {
            break;
        }
    }
    let silent: Vec<_> = silent.into_iter().filter_map(|(board, error)| Some((board, error?))).collect();
    match silent.last() {
        Some((_, last)) if silent.len() == boards.len() => {
            Err(NoBoards { devices: boards.len(), waited_s: wait_s, last: last.clone() })
        }
        _ => Ok(silent),
    }
}
