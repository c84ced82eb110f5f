use super::SimError;
use super::clock::saturating_ns;
use super::port::{VirtualPort, Wake};
use rustix::io::{read, write};
use std::thread;
use std::time::{Duration, Instant};

/// Exchanges measured; the median is exact enough and it takes some 50 ms.
const EXCHANGES: u8 = 200;
/// Pause between two, so that both sides sleep as they do between the packets of a bus.
const PAUSE: Duration = Duration::from_micros(150);
/// What an exchange may take before it is given up as lost to the scheduler, ns.
const PATIENCE_NS: u64 = 20_000_000;

/// Median time, ns, from writing ten bytes to a pty until ten bytes have come back from a thread
/// that sleeps on the other side and writes at once. With `spin`, this side looks for them without
/// sleeping.
///
/// # Errors
/// The system gives no pseudo-terminal.
pub fn measure_round_trip_ns(spin: bool) -> Result<u64, SimError> {
    let port = VirtualPort::open(None)?;
    let client = port.open_client().map_err(SimError::pty("open"))?;
    thread::scope(|scope| {
        scope.spawn(move || {
            let mut packet = [0; 10];
            let mut filled = 0;
            // Ends with the other side: a byte of 0xFF, which no measurement sends first.
            while let Ok(count @ 1..) = read(&client, &mut packet[filled..]) {
                filled += count;
                if packet[0] == END {
                    break;
                }
                if filled == packet.len() {
                    filled = 0;
                    if write(&client, &packet).is_err() {
                        break;
                    }
                }
            }
        });
        let measured = measure(&port, spin);
        let told = port.write(&[END]);
        let mut times = measured.and_then(|times| told.map(|_| times)).map_err(SimError::pty("measure"))?;
        times.sort_unstable();
        Ok(times.get(times.len() / 2).copied().unwrap_or(0))
    })
}

const END: u8 = 0xFF;

fn measure(port: &VirtualPort, spin: bool) -> rustix::io::Result<Vec<u64>> {
    let mut times = Vec::with_capacity(EXCHANGES.into());
    let nap_ns = if spin { 0 } else { PATIENCE_NS };
    for exchange in 0..EXCHANGES {
        thread::sleep(PAUSE);
        let start = Instant::now();
        port.write(&[exchange; 10])?;
        let mut buffer = [0; 64];
        let mut heard = 0;
        while heard < 10 && saturating_ns(start.elapsed()) < PATIENCE_NS {
            if port.wait(nap_ns)? == Wake::Bytes {
                let count = port.read(&mut buffer)?.unwrap_or(0);
                // An answer that comes after it was given up must not be taken for the next one.
                heard += buffer[..count].iter().filter(|&&byte| byte == exchange).count();
            }
        }
        times.push(saturating_ns(start.elapsed()));
    }
    Ok(times)
}
