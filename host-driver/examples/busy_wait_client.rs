//! A client that waits for answers as the original's does: it asks the kernel over and over whether
//! a byte is there, and never sleeps. It has no timeouts, checks or statistics to speak of; it is
//! here to be measured beside `pneudrive-host bench`, on the same machine in the same minutes.
//!
//! ```console
//! $ cargo run --release -p pneudrive-host --example busy_wait_client -- PORT BOARDS [SECONDS]
//! ```

use std::error::Error;
use std::time::{Duration, Instant};

use pneudrive_protocol::{Address, CHANNELS, Counts, PACKET_LEN, Packet};
use rustix::fs::{Mode, OFlags, open};
use rustix::io::{ioctl_fionread, read, write};
use rustix::termios::{OptionalActions, QueueSelector, tcflush, tcgetattr, tcsetattr};
use rustix::time::{ClockId, clock_gettime};

/// A board that has not answered by then is lost.
const TIMEOUT: Duration = Duration::from_millis(10);

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (Some(port), Some(boards)) = (arguments.first(), arguments.get(1)) else {
        return Err("expected PORT BOARDS [SECONDS]".into());
    };
    let boards: u8 = boards.parse()?;
    let seconds: f64 = arguments.get(2).map_or(Ok(2.0), |text| text.parse())?;

    let file = open(port.as_str(), OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty())?;
    let mut settings = tcgetattr(&file)?;
    settings.make_raw();
    settings.set_speed(1_000_000)?;
    tcsetattr(&file, OptionalActions::Now, &settings)?;
    tcflush(&file, QueueSelector::IOFlush)?;

    let (started, cpu) = (Instant::now(), cpu_s());
    let (mut cycles_us, mut lost) = (Vec::new(), 0);
    while started.elapsed().as_secs_f64() < seconds {
        let begun = Instant::now();
        for board in 0..boards {
            let request =
                Packet { address: Address::of_board(board), values: [Counts::ATMOSPHERE; CHANNELS] };
            write(&file, &request.encode())?;
            let asked = Instant::now();
            let mut have = 0;
            while have < PACKET_LEN && asked.elapsed() < TIMEOUT {
                if ioctl_fionread(&file)? > 0 {
                    have += read(&file, &mut [0; 1])?;
                }
            }
            lost += u32::from(have < PACKET_LEN);
        }
        cycles_us.push(begun.elapsed().as_secs_f64() * 1e6);
    }
    let elapsed_s = started.elapsed().as_secs_f64();
    cycles_us.sort_by(f64::total_cmp);
    println!(
        "{boards} boards: {:.0} Hz, median cycle {:.0} us, {lost} lost, {:.0} % of a core",
        cycles_us.len() as f64 / elapsed_s,
        cycles_us[cycles_us.len() / 2],
        100.0 * (cpu_s() - cpu) / elapsed_s
    );
    Ok(())
}

/// CPU time of this process, s.
fn cpu_s() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}
