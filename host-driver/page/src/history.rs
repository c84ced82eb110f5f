//! The last minute, for clients that open the page later.

use serde::Serialize;
use std::collections::VecDeque;

/// A moment: every channel of every board, in the poller's order.
#[derive(Debug, Clone)]
struct Moment {
    t_s: f64,
    command_kpa: Vec<f64>,
    /// `None` where there was no fresh reading.
    pressure_kpa: Vec<Option<f64>>,
}

/// The last minute in steps of a tenth of a second.
#[derive(Debug, Clone, Default)]
pub(crate) struct History {
    moments: VecDeque<Moment>,
}

/// As it is sent: a list of times, and lists as long for every channel.
#[derive(Debug, Serialize)]
pub(crate) struct Past {
    t: Vec<f64>,
    c: Vec<Vec<f64>>,
    p: Vec<Vec<Option<f64>>>,
}

impl History {
    const LENGTH_S: f64 = 60.0;
    const STEP_S: f64 = 0.1;

    /// Takes what was seen at `t_s`, unless the last moment is too near.
    pub(crate) fn add(&mut self, t_s: f64, channels: impl Iterator<Item = (f64, Option<f64>)>) {
        // Half a picture of slack: the steps are whole pictures.
        if self.moments.back().is_some_and(|last| t_s < last.t_s + Self::STEP_S - 0.017) {
            return;
        }
        let (command_kpa, pressure_kpa) = channels.unzip();
        self.moments.push_back(Moment { t_s, command_kpa, pressure_kpa });
        while self.moments.front().is_some_and(|first| first.t_s < t_s - Self::LENGTH_S) {
            self.moments.pop_front();
        }
    }

    pub(crate) fn past(&self) -> Past {
        let channels = self.moments.back().map_or(0, |moment| moment.command_kpa.len());
        let of =
            |channel: usize| self.moments.iter().map(move |moment| moment.command_kpa[channel]).collect();
        let measured =
            |channel: usize| self.moments.iter().map(move |moment| moment.pressure_kpa[channel]).collect();
        Past {
            t: self.moments.iter().map(|moment| moment.t_s).collect(),
            c: (0..channels).map(of).collect(),
            p: (0..channels).map(measured).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_minute_in_tenths() {
        let mut history = History::default();
        for picture in 0..3_000 {
            let t_s = f64::from(picture) / 30.0;
            history.add(t_s, [(1.0, Some(t_s)), (2.0, None)].into_iter());
        }
        let past = history.past();
        assert_eq!((past.c.len(), past.p.len()), (2, 2));
        assert!((600..=602).contains(&past.t.len()), "{}", past.t.len());
        assert!((past.t[past.t.len() - 1] - past.t[0] - 60.0).abs() < 0.11);
        assert!(past.p[0].iter().zip(&past.t).all(|(p, t)| *p == Some(*t)));
        assert!(past.p[1].iter().all(Option::is_none) && past.c[1].iter().all(|&c| c == 2.0));
    }
}
