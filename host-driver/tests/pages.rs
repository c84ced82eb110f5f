//! Page requests between polls: what they cost, what they leave alone, and what is recorded. In
//! virtual time.

use crate::support::virtual_line::{AT_ONCE, Reply, VirtualLine};
use crate::support::{answer, counts};
use pneudrive_host::Calibration;
use pneudrive_host::bus::{BoardFormat, Bus, BusOptions, EchoMode, ExchangeError, FormatPolicy, PageError};
use pneudrive_host::line::Line;
use pneudrive_host::poller::{Event, Observer, Pace, PageShare, PollerOptions, Polling, Row, SetPoints};
use pneudrive_protocol::pages::{
    About, ChannelNow, ChipKind, Counter, Drives, NO_SUCH_ENTRY, NowState, PageEntry, PostMortem, StateNow,
    StopCause, number_entry,
};
use pneudrive_protocol::{Address, Asked, Counts, Echo, RequestDecoder};
use pneudrive_record::{PageColumns, Recorder, RecorderOptions};
use std::sync::{Arc, Mutex};
use std::time::Duration;

const DRIVES: [i16; 4] = [400, -400, 0, 1];

/// A board that checks, and answers page requests unless its firmware is of before pages. Remembers
/// what it was asked.
fn board(pages: bool, asked: &Arc<Mutex<Vec<Asked>>>) -> impl FnMut(usize, &[u8]) -> Reply + Send + use<> {
    let address = Address::of_board(0);
    let mut ear = RequestDecoder::new(address);
    let asked = Arc::clone(asked);
    let record = PostMortem { cause: StopCause::panic("src/bus.rs", 42), at_us: 1_500_000 }.to_words();
    move |_, request| {
        let Some(heard) = request.iter().filter_map(|&byte| ear.push(byte)).last() else { return Vec::new() };
        asked.lock().unwrap().push(heard);
        let bytes = match heard {
            Asked::Pressures(request) => request.answer(address, counts(500)),
            Asked::Page(_) if !pages => return Vec::new(),
            Asked::Page(request) => {
                let entry = request.entry().map(|entry| match entry {
                    PageEntry::State => {
                        NowState { board: StateNow::Running, channels: [ChannelNow::Regulating; 4] }
                            .to_entry()
                    }
                    PageEntry::Drives => Drives::new(DRIVES).to_entry(),
                    PageEntry::About => About { chip: ChipKind::Rp2040, version: [1, 2, 3] }.to_entry(),
                    PageEntry::Counter(counter) => number_entry(1_000_000_000 + counter as u32),
                    PageEntry::PostMortemWord(word) => number_entry(record[usize::from(word)]),
                    // Firmware of before sessions and parameters.
                    _ => NO_SUCH_ENTRY,
                });
                request.answer(entry).encode()
            }
        };
        vec![(AT_ONCE, bytes.to_vec())]
    }
}

fn bus(script: impl FnMut(usize, &[u8]) -> Reply + Send + 'static) -> Bus<VirtualLine> {
    let options = BusOptions::default()
        .echo(EchoMode::Known(Echo::Absent))
        .formats(FormatPolicy::Negotiate)
        .sessions(false);
    Bus::new(VirtualLine::new(script), options).unwrap()
}

#[test]
fn a_board_of_which_nothing_is_known_tells_everything_and_is_commanded_nothing() {
    let asked = Arc::default();
    let mut bus = bus(board(true, &asked));
    assert_eq!(bus.about(0).unwrap(), About { chip: ChipKind::Rp2040, version: [1, 2, 3] });
    assert_eq!(bus.format(0), BoardFormat::Checked);
    assert_eq!(bus.board_state(0).unwrap().board, StateNow::Running);
    assert_eq!(bus.drives(0).unwrap().0.counts(), DRIVES);
    assert_eq!(bus.counter(0, Counter::UptimeS).unwrap(), 1_000_000_012);
    let record = bus.post_mortem(0, 1).unwrap().unwrap();
    assert_eq!(record.to_string(), "panic at src/bus.rs:42, 1.500000 s after start");
    assert!(asked.lock().unwrap().iter().all(|asked| matches!(asked, Asked::Page(_))));
    let counters = bus.counters(0);
    assert_eq!((counters.asked, counters.pages_asked, counters.pages_answered), (0, 17, 17));
}

/// A board of the original kind drops the request and answers it with its pressures; afterwards it
/// is not asked again.
#[test]
fn a_board_of_the_original_kind_is_asked_for_a_page_once() {
    let mut bus = bus(|_, request| vec![(AT_ONCE, answer(0xFF - request[1], 7))]);
    let first = bus.drives(0).unwrap_err();
    assert!(matches!(first, PageError::Exchange(ExchangeError::OriginalFormat { .. })), "{first}");
    assert!(matches!(bus.drives(0), Err(PageError::NotChecked { .. })));
    assert_eq!(bus.line().requests.len(), 1);
}

/// The answer to a page request comes after its timeout, and right before that to a poll: it is
/// nobody's pressures.
#[test]
fn a_late_page_is_no_reading() {
    let asked = Arc::default();
    let mut checks = board(true, &asked);
    let mut bus = bus(move |number, request| {
        let mut reply = checks(number, request);
        if number == 1 {
            reply[0].0 = 2_250_000;
        }
        reply
    });
    bus.line_mut().one_speaker = true;
    assert_eq!(bus.ping(0).unwrap().pressures, counts(500));
    assert!(bus.drives(0).is_err());
    assert_eq!(bus.exchange(0, counts(200)).unwrap().pressures, counts(500));
    let counters = bus.counters(0);
    assert_eq!((counters.lost(), counters.pages_asked, counters.pages_answered), (0, 2 - 1, 0));
}

/// What a run's observers are told.
#[derive(Clone, Default)]
struct Told(Arc<Mutex<(Vec<bool>, Vec<String>)>>);

impl Observer for Told {
    fn row(&mut self, row: &Row<'_>) {
        let drives = row.boards[0].drives.map(|reading| reading.drives.counts());
        assert!(drives.is_none_or(|drives| drives == DRIVES));
        self.0.lock().unwrap().0.push(drives.is_some());
    }

    fn event(&mut self, event: &Event<'_>) {
        if let Event::NoDrives { board, .. } = event {
            self.0.lock().unwrap().1.push(format!("no drives of board {board}"));
        }
    }
}

/// One board at 1 kHz for `cycles`, asked for its drives after this share of the polls.
fn poll(pages: bool, share: f64, cycles: usize, more: Option<Box<dyn Observer>>) -> (Told, Vec<Asked>, u64) {
    let asked = Arc::default();
    let told = Told::default();
    let options = PollerOptions::for_devices(1)
        .pace(Pace::every(Duration::from_millis(1)))
        .drives(PageShare::new(share).unwrap());
    let mut observers: Vec<Box<dyn Observer>> = vec![Box::new(told.clone())];
    observers.extend(more);
    let mut polling =
        Polling::new(bus(board(pages, &asked)), options, Box::new(SetPoints::new(1)), observers);
    for _ in 0..cycles {
        let at_ns = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(at_ns);
        polling.cycle().unwrap();
    }
    let lost = polling.statistics().boards[0].lost;
    drop(polling);
    let asked = asked.lock().unwrap().clone();
    (told, asked, lost)
}

#[test]
fn a_share_of_the_polls_is_followed_by_a_request_for_drives() {
    for (share, every) in [(1.0, 1), (0.5, 2), (0.1, 10)] {
        let (told, asked, lost) = poll(true, share, 1_000, None);
        let expected: Vec<_> = (0..1_000).map(|cycle| cycle % every == 0).collect();
        assert_eq!((&told.0.lock().unwrap().0, lost), (&expected, 0), "share {share}");
        let pages = asked.iter().filter(|asked| matches!(asked, Asked::Page(_))).count();
        assert_eq!((pages, asked.len() - pages), (1_000 / every, 1_000));
    }
}

/// Firmware of before pages: its polls go on as before, and what is lost is not counted with them.
#[test]
fn a_board_without_pages_is_polled_as_before() {
    let (told, asked, lost) = poll(false, 1.0, 3_000, None);
    let told = told.0.lock().unwrap();
    assert_eq!((told.1.clone(), lost), (vec!["no drives of board 0".to_owned()], 0));
    assert!(told.0.iter().all(|&drives| !drives));
    let pages = asked.iter().filter(|asked| matches!(asked, Asked::Page(_))).count();
    assert_eq!(pages, 3 + 2, "three at once, then one a second");
    assert_eq!(asked.len() - pages, 3_000);
}

#[test]
fn a_recording_has_the_drives_of_the_cycles_that_were_asked() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let how = RecorderOptions::default().pages(PageColumns { drives: true, sensors: false });
    let (recorder, tap) = Recorder::create_with(&file, &[0], Calibration::default(), &how).unwrap();
    poll(true, 0.5, 4, Some(tap));
    recorder.finish().unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    let rows: Vec<_> = text.lines().filter(|line| !line.starts_with('#')).collect();
    assert!(rows[0].ends_with(",b0_p3_kpa,b0_u0,b0_u1,b0_u2,b0_u3"), "{text}");
    let told: Vec<_> = rows[1..].iter().map(|row| row.ends_with(",1.0000,-1.0000,0.0000,0.0025")).collect();
    assert_eq!(told, [true, false, true, false], "{text}");
    assert!(rows[2].ends_with(",,,,"), "{text}");
}

/// `Counts` of a poll that follow a page request are those commanded: nothing of a page gets into a
/// command.
#[test]
fn commands_between_page_requests_are_those_commanded() {
    let (_, asked, _) = poll(true, 1.0, 50, None);
    let commands = asked.iter().filter_map(|asked| asked.pressures()).map(|request| request.commands);
    assert!(commands.into_iter().all(|commands| commands == [Counts::ATMOSPHERE; 4]));
}
