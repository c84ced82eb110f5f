//! Boards behind a pty, as fast as the pty is.

use pneudrive_protocol::{Address, Asked, CHANNELS, CheckedPacket, Counts, RequestDecoder};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::JoinHandle;

/// What a board was commanded.
pub type Commanded = (u8, [Counts; CHANNELS]);

/// `boards` boards that answer their commands as pressures, and a switch that unplugs the last of
/// them.
pub struct PtyBoards {
    path: PathBuf,
    stop: Arc<AtomicBool>,
    pub last_unplugged: Arc<AtomicBool>,
    /// Requests that were answered.
    #[allow(dead_code, reason = "for tests of the page")]
    pub answered: Arc<AtomicUsize>,
    thread: Option<JoinHandle<Vec<Commanded>>>,
    /// Keeps the pty alive between hosts.
    _slave: OwnedFd,
}

impl PtyBoards {
    pub fn start(boards: u8) -> Self {
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let master = openpt(flags).unwrap();
        grantpt(&master).unwrap();
        unlockpt(&master).unwrap();
        let name = ptsname(&master, Vec::new()).unwrap();
        let path = PathBuf::from(name.to_str().unwrap());
        let slave = rustix::fs::open(
            &path,
            rustix::fs::OFlags::RDWR | rustix::fs::OFlags::NOCTTY | rustix::fs::OFlags::CLOEXEC,
            rustix::fs::Mode::empty(),
        )
        .unwrap();
        let mut settings = tcgetattr(&slave).unwrap();
        settings.make_raw();
        tcsetattr(&slave, OptionalActions::Now, &settings).unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let last_unplugged = Arc::new(AtomicBool::new(false));
        let answered = Arc::new(AtomicUsize::new(0));
        let (stops, unplugs, counts) =
            (Arc::clone(&stop), Arc::clone(&last_unplugged), Arc::clone(&answered));
        let thread = std::thread::spawn(move || serve(&master, boards, &stops, &unplugs, &counts));
        Self { path, stop, last_unplugged, answered, thread: Some(thread), _slave: slave }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Ends the boards; returns all commands they got, in order.
    pub fn stop(mut self) -> Vec<Commanded> {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.take().unwrap().join().unwrap()
    }
}

impl Drop for PtyBoards {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn serve(
    master: &OwnedFd,
    boards: u8,
    stop: &AtomicBool,
    unplugged: &AtomicBool,
    answered: &AtomicUsize,
) -> Vec<Commanded> {
    let mut ears: Vec<_> = (0..boards).map(|board| RequestDecoder::new(Address::of_board(board))).collect();
    let mut commands = Vec::new();
    while !stop.load(Ordering::Relaxed) {
        let mut files = [PollFd::new(master, PollFlags::IN)];
        let patience = Timespec { tv_sec: 0, tv_nsec: 20_000_000 };
        if poll(&mut files, Some(&patience)).unwrap_or(0) == 0 {
            continue;
        }
        let mut bytes = [0; 256];
        let Ok(count) = rustix::io::read(master, &mut bytes) else { continue };
        for &byte in &bytes[..count] {
            for ear in &mut ears {
                let address = ear.address();
                let Some(request) = ear.push(byte).and_then(Asked::pressures) else { continue };
                if unplugged.load(Ordering::Relaxed) && address.board() + 1 == boards {
                    continue;
                }
                // A host that leaves says so in the end; tests ask for what it commanded.
                if request.commands != CheckedPacket::LEAVE {
                    commands.push((address.board(), request.commands));
                }
                let _ = rustix::io::write(master, &request.answer(address, request.commands));
                answered.fetch_add(1, Ordering::Relaxed);
            }
        }
    }
    commands
}
