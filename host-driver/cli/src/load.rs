//! How busy the computer is with other programs: then a measurement measures that.

use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs;
use std::time::{Duration, Instant};

/// The kernel's counts when something began to be measured.
pub struct LoadMeter {
    since: Instant,
    own: Duration,
    /// By the thread's number, ns.
    waited_ns: BTreeMap<u32, u64>,
    cores: Option<Cores>,
}

/// What the computer did meanwhile, as shares; `None` where the kernel does not count it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Load {
    /// Time that this program waited for a core: that of its thread which waited longest.
    pub core_wait_share: Option<f64>,
    /// What other programs used of all cores.
    pub other_programs_share: Option<f64>,
}

/// Ticks of all cores together, and how many there are.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Cores {
    count: u32,
    all: u64,
    idle: u64,
}

impl LoadMeter {
    pub fn begin() -> Self {
        let cores = fs::read_to_string("/proc/stat").ok().and_then(|text| Cores::parse(&text));
        Self { since: Instant::now(), own: cpu_time(), waited_ns: waited_ns(), cores }
    }

    /// What has been since then.
    pub fn load(&self) -> Load {
        let elapsed_s = self.since.elapsed().as_secs_f64();
        let new = waited_ns().into_iter().map(|(thread, ns)| {
            let before = self.waited_ns.get(&thread).copied().unwrap_or(0);
            ns.saturating_sub(before) as f64 * 1e-9
        });
        let core_wait_share = new.reduce(f64::max).map(|longest_s| longest_s / elapsed_s);
        let own_s = cpu_time().saturating_sub(self.own).as_secs_f64();
        let now = fs::read_to_string("/proc/stat").ok().and_then(|text| Cores::parse(&text));
        let other_programs_share = self.cores.zip(now).and_then(|(before, now)| {
            let all = now.all.checked_sub(before.all).filter(|&ticks| ticks > 0)?;
            let idle = now.idle.saturating_sub(before.idle) as f64 / all as f64;
            Some((1.0 - idle - own_s / elapsed_s / f64::from(now.count)).clamp(0.0, 1.0))
        });
        Load { core_wait_share, other_programs_share }
    }
}

impl Load {
    /// Waking up alone costs a few us each, up to some hundredths of the time.
    const MOST_WAIT: f64 = 0.1;
    /// A desktop has some hundredths of its own.
    const MOST_OTHERS: f64 = 0.2;

    /// What is to be said of it, if figures are those of other programs too.
    pub fn words(&self) -> Option<String> {
        let (waited, others) =
            (self.core_wait_share.unwrap_or(0.0), self.other_programs_share.unwrap_or(0.0));
        (waited >= Self::MOST_WAIT || others >= Self::MOST_OTHERS).then(|| {
            format!(
                "the computer was busy (other programs used {:.0} % of it, this one waited for a core {:.0} % of the time)",
                100.0 * others,
                100.0 * waited
            )
        })
    }

    /// The busier of both.
    pub fn or_worse(self, other: Self) -> Self {
        let most = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::max);
        Self {
            core_wait_share: most(self.core_wait_share, other.core_wait_share),
            other_programs_share: most(self.other_programs_share, other.other_programs_share),
        }
    }
}

impl Cores {
    fn parse(stat: &str) -> Option<Self> {
        let mut lines = stat.lines().take_while(|line| line.starts_with("cpu"));
        let ticks = lines.next()?.split_whitespace().skip(1).map(|word| word.parse().ok());
        // Behind these eight stand guests' ticks, which are in the first two.
        let ticks: Vec<u64> = ticks.take(8).collect::<Option<_>>()?;
        let idle = ticks.get(3..5)?.iter().sum();
        Some(Self { count: u32::try_from(lines.count()).ok()?.max(1), all: ticks.iter().sum(), idle })
    }
}

/// Of all threads of this program.
fn cpu_time() -> Duration {
    clock_gettime(ClockId::ProcessCPUTime).try_into().unwrap_or_default()
}

/// Of each thread of this program, from its beginning on.
fn waited_ns() -> BTreeMap<u32, u64> {
    let Ok(threads) = fs::read_dir("/proc/self/task") else { return BTreeMap::new() };
    let of = |thread: fs::DirEntry| {
        let number = thread.file_name().to_str()?.parse().ok()?;
        Some((number, second(&fs::read_to_string(thread.path().join("schedstat")).ok()?)?))
    };
    threads.flatten().filter_map(of).collect()
}

/// What stands behind the time on a core.
fn second(schedstat: &str) -> Option<u64> {
    schedstat.split_whitespace().nth(1)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernels_counts_are_understood() {
        assert_eq!(second("158609 2087781 2\n"), Some(2_087_781));
        assert_eq!(second("0\n"), None);
        let stat = "cpu  10 20 30 400 5 6 7 8 9 9\ncpu0 5 10 15 200 2 3 3 4 4 4\ncpu1 5 10 15 200 3 3 4 4 5 5\nintr 1\n";
        assert_eq!(Cores::parse(stat), Some(Cores { count: 2, all: 486, idle: 405 }));
        assert_eq!(Cores::parse("intr 1\n"), None);
    }

    #[test]
    fn a_quiet_computer_is_not_worth_a_word() {
        let quiet = Load { core_wait_share: Some(0.02), other_programs_share: Some(0.05) };
        assert_eq!((quiet.words(), Load::default().words()), (None, None));
        let busy = quiet.or_worse(Load { core_wait_share: None, other_programs_share: Some(0.68) });
        let said = "the computer was busy (other programs used 68 % of it, this one waited for a core 2 % of the time)";
        assert_eq!(busy.words().as_deref(), Some(said));
    }

    /// More threads than cores, each of which wants one all the time.
    #[test]
    fn waiting_for_a_core_is_seen() {
        let meter = LoadMeter::begin();
        let threads = 4 * std::thread::available_parallelism().map_or(1, usize::from);
        std::thread::scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|| {
                    let started = Instant::now();
                    while started.elapsed().as_millis() < 500 {}
                });
            }
            std::thread::sleep(Duration::from_millis(300));
            let load = meter.load();
            assert!(load.core_wait_share.is_none() || load.words().is_some(), "{load:?}");
        });
    }
}
