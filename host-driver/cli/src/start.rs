//! What is checked and said before a run starts.

use crate::args::{BusArgs, RunArgs, SessionsArg};
use crate::failure::Failure;
use crate::setup::Setup;
use crate::view::Events;
use pneudrive_host::notices::{Notice, NoticeKind};
use pneudrive_host::poller::Limits;
use pneudrive_host::rig::Rig;
use pneudrive_protocol::CHANNELS;
use pneudrive_record::Description;
use std::collections::BTreeMap;
use std::path::Path;

/// Refuses to replace a file that is read, under whatever name.
pub fn not_read_from(record: &Path, args: &BusArgs, run: &RunArgs) -> Result<(), Failure> {
    use std::os::unix::fs::MetadataExt;
    let identity = |path: &Path| path.metadata().ok().map(|status| (status.dev(), status.ino()));
    let written = identity(record);
    for (option, path) in [("--trajectory", &run.trajectory), ("--rig", &args.rig)] {
        if let (Some(written), Some(path)) = (written, path)
            && identity(path) == Some(written)
        {
            return Err(Failure::input(format!(
                "--record {}: it is the file of {option} {}, which would be lost; choose another name",
                record.display(),
                path.display()
            )));
        }
    }
    Ok(())
}

/// What recordings say of the run.
pub fn description(
    args: &BusArgs,
    run: &RunArgs,
    devices: u16,
    setup: &Setup,
    limits: &Limits,
) -> Description {
    let command_line: Vec<_> = super::line().iter().map(|arg| arg.to_string_lossy().into_owned()).collect();
    let name = |path: &Path| path.to_string_lossy().into_owned();
    let mut description = Description::default()
        .with("command_line", command_line)
        .with("port", args.port.as_deref().map(name))
        .with("baud", args.baud())
        .with("baud_auto", args.line_rate().is_some())
        .with("sessions", args.sessions == SessionsArg::On)
        .with("rate_hz", run.rate);
    if *limits != Limits::default() {
        // One who is not limited has an infinite limit, which is null in JSON.
        let of = |board| limits.of(board).map(|limit| (limit.max_kpa, limit.max_rate_kpa_s));
        let boards: Vec<_> = (0..=u8::MAX).take(usize::from(devices)).map(of).collect();
        let max_kpa: Vec<_> = boards.iter().map(|board| board.map(|limit| limit.0)).collect();
        let max_rate: Vec<_> = boards.iter().map(|board| board.map(|limit| limit.1)).collect();
        description = description.with("max_kpa", max_kpa).with("max_rate_kpa_s", max_rate);
    }
    if let Some(rig) = &setup.rig {
        description = description.with("rig_file", rig.file()).with("rig", rig.text());
        let names = names(rig, devices);
        if !names.is_empty() {
            description = description.with("names", names);
        }
    }
    description
}

/// What the rig file calls boards and channels: `board` or a channel's number, by the board's
/// number.
fn names(rig: &Rig, devices: u16) -> BTreeMap<u8, BTreeMap<String, String>> {
    let of = |board: u8| {
        let own = rig.board_name(board).map(|name| ("board".to_owned(), name.to_owned()));
        let channels = (0..CHANNELS)
            .filter_map(|channel| Some((channel.to_string(), rig.channel_name(board, channel)?.to_owned())));
        (board, own.into_iter().chain(channels).collect::<BTreeMap<_, _>>())
    };
    (0..=u8::MAX).take(usize::from(devices)).map(of).filter(|(_, names)| !names.is_empty()).collect()
}

/// Says why the boards may not do at once what they are commanded.
pub fn tell(first_row_s: Option<f64>, events: &Events) {
    if let Some(seconds) = first_row_s.filter(|&seconds| seconds > 0.0) {
        let text = format!(
            "the trajectory begins at {seconds:.3} s; --from-first-row begins with its first row at once"
        );
        events.happened(Notice::new(NoticeKind::Information, text));
    }
}
