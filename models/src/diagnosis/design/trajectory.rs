//! The command file that `pneudrive-host --trajectory` plays.

use std::fmt::Write;

use super::menu::{Excitation, PERIOD_S};
use crate::diagnosis::channel::ChannelData;

/// `t_s` and one command column a channel; rows where nothing changes are left out, because the
/// host holds a row until the next.
#[must_use]
pub fn csv(channels: &[ChannelData], excitation: Excitation, range_kpa: [f64; 2]) -> String {
    let commands: Vec<Vec<f64>> =
        (0..channels.len()).map(|k| excitation.commands(k, channels.len(), range_kpa)).collect();
    let mut text = "t_s".to_owned();
    for data in channels {
        text.push(',');
        text.push_str(&data.id.command_column());
    }
    text.push('\n');
    let rows = commands.first().map_or(0, Vec::len);
    let changes = |k: usize| commands.iter().any(|c| c[k].total_cmp(&c[k - 1]).is_ne());
    for k in (0..rows).filter(|&k| k == 0 || k + 1 == rows || changes(k)) {
        // Writing to a String cannot fail.
        let _ = write!(text, "{:.2}", k as f64 * PERIOD_S);
        for channel in &commands {
            let _ = write!(text, ",{:.2}", channel[k]);
        }
        text.push('\n');
    }
    text
}
