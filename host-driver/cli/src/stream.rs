//! Rows as datagrams, for programs that draw what they hear: PlotJuggler's UDP server takes JSON.
//!
//! A datagram is one object: `t_s` and the columns of a recording by their names, such as
//! `b0_p3_kpa`. Where a board gave no answer its pressures are left out. Nobody has to listen: what
//! cannot be sent is dropped, and the bus thread never waits.

use pneudrive_host::Calibration;
use pneudrive_host::poller::{Observer, Row};
use std::fmt::Write as _;
use std::io;
use std::net::{SocketAddr, ToSocketAddrs, UdpSocket};
use thiserror::Error;

/// Sends rows to one address.
#[derive(Debug)]
pub struct UdpStream {
    socket: UdpSocket,
    calibration: Calibration,
    period_ns: u64,
    due_ns: u64,
    text: String,
}

/// An address that cannot be sent to.
#[derive(Debug, Error)]
#[error("{address}: {reason}")]
#[non_exhaustive]
pub struct StreamError {
    /// As given.
    pub address: String,
    /// Why.
    pub reason: io::Error,
}

impl UdpStream {
    /// Rows a second at most: more than a screen shows, and no load for a bus of 1 kHz.
    pub const MOST_HZ: f64 = 100.0;

    /// To `address`, as in `127.0.0.1:9870` or `laptop:9870`.
    ///
    /// # Errors
    /// No such address, or no way to it.
    pub fn to(address: &str, calibration: impl Into<Calibration>) -> Result<Self, StreamError> {
        let refused = |reason: io::Error| {
            let reason = match reason.kind() {
                io::ErrorKind::InvalidInput => io::Error::other("expected HOST:PORT, such as 127.0.0.1:9870"),
                _ => reason,
            };
            StreamError { address: address.to_owned(), reason }
        };
        let found: SocketAddr = address
            .to_socket_addrs()
            .and_then(|mut all| all.next().ok_or_else(|| io::Error::other("no such address")))
            .map_err(refused)?;
        let any: SocketAddr = if found.is_ipv4() { ([0, 0, 0, 0], 0).into() } else { ([0_u16; 8], 0).into() };
        let socket = UdpSocket::bind(any).map_err(refused)?;
        socket.connect(found).and_then(|()| socket.set_nonblocking(true)).map_err(refused)?;
        Ok(Self {
            socket,
            calibration: calibration.into(),
            period_ns: (1e9 / Self::MOST_HZ) as u64,
            due_ns: 0,
            text: String::new(),
        })
    }

    /// The row as text, in `self.text`.
    fn write(&mut self, row: &Row<'_>) {
        let text = &mut self.text;
        text.clear();
        // Writing to a String does not fail.
        let _ = write!(text, "{{\"t_s\":{:.6}", row.since_start_ns as f64 * 1e-9);
        for board in row.boards {
            let n = board.board;
            for (k, kpa) in self.calibration.command_kpa(n, board.command).into_iter().enumerate() {
                let _ = write!(text, ",\"b{n}_cmd{k}_kpa\":{kpa:.3}");
            }
            let Some(reading) = board.fresh() else { continue };
            for (k, kpa) in self.calibration.kpa(n, reading.counts).into_iter().enumerate() {
                let _ = write!(text, ",\"b{n}_p{k}_kpa\":{kpa:.3}");
            }
            for (k, share) in board.drives.iter().flat_map(|reading| reading.drives.share()).enumerate() {
                let _ = write!(text, ",\"b{n}_u{k}\":{share:.4}");
            }
            if let Some(supply) = board.sensors.new_supply() {
                let _ = write!(text, ",\"b{n}_supply_kpa\":{:.2}", supply.kpa);
            }
        }
        text.push('}');
    }
}

impl Observer for UdpStream {
    fn row(&mut self, row: &Row<'_>) {
        // A row that comes a little early, by jitter, is not left out.
        if row.at_ns + self.period_ns / 4 < self.due_ns {
            return;
        }
        // Slower rows than asked for are due at once, and nothing is made up for.
        if row.at_ns > self.due_ns + self.period_ns {
            self.due_ns = row.at_ns;
        }
        self.due_ns += self.period_ns;
        self.write(row);
        // Nobody listens, or the network is full: neither is the bus's business.
        let _ = self.socket.send(self.text.as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneudrive_host::poller::{
        BoardRow, BoardSensors, BoardState, DriveReading, Outcome, Reading, SupplyPressure, VENTED,
    };
    use pneudrive_protocol::Counts;
    use pneudrive_protocol::pages::Drives;

    fn board(outcome: Outcome) -> BoardRow {
        let counts = [Counts::saturating(221); 4];
        BoardRow {
            board: 1,
            command: VENTED,
            wanted: VENTED,
            outcome,
            reading: Some(Reading { counts, kpa: [0.0; 4], asked_ns: 0 }),
            drives: (outcome == Outcome::Fresh)
                .then(|| DriveReading { drives: Drives::new([400, -400, 0, 1]), asked_ns: 0 }),
            sensors: BoardSensors {
                supply: Some(SupplyPressure { kpa: 549.5, measured_ns: 0 }),
                supply_is_new: true,
                ..BoardSensors::default()
            },
            state: BoardState::Present,
        }
    }

    #[test]
    fn a_row_is_one_object_with_the_columns_of_a_recording() {
        let listener = UdpSocket::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let mut stream = UdpStream::to(&address, Calibration::default()).unwrap();
        let mut send = |at_ns, outcome| {
            stream.row(&Row { cycle: 0, at_ns, since_start_ns: at_ns, boards: &[board(outcome)] });
        };
        send(1_000_000_000, Outcome::Fresh);
        // 5 ms later is too soon, 10 ms later is not.
        send(1_005_000_000, Outcome::Fresh);
        send(1_010_000_000, Outcome::Lost);
        let next = || {
            let mut bytes = [0; 1024];
            let count = listener.recv(&mut bytes).unwrap();
            String::from_utf8(bytes[..count].to_vec()).unwrap()
        };
        let commands =
            "\"b1_cmd0_kpa\":0.000,\"b1_cmd1_kpa\":0.000,\"b1_cmd2_kpa\":0.000,\"b1_cmd3_kpa\":0.000";
        let pressures = "\"b1_p0_kpa\":99.819,\"b1_p1_kpa\":99.819,\"b1_p2_kpa\":99.819,\"b1_p3_kpa\":99.819";
        let drives = "\"b1_u0\":1.0000,\"b1_u1\":-1.0000,\"b1_u2\":0.0000,\"b1_u3\":0.0025";
        assert_eq!(
            next(),
            format!("{{\"t_s\":1.000000,{commands},{pressures},{drives},\"b1_supply_kpa\":549.50}}")
        );
        assert_eq!(next(), format!("{{\"t_s\":1.010000,{commands}}}"));
    }

    #[test]
    fn nobody_has_to_listen() {
        let mut stream = UdpStream::to("127.0.0.1:9", Calibration::default()).unwrap();
        for at_ns in 0..10 {
            stream.row(&Row {
                cycle: 0,
                at_ns: at_ns * 20_000_000,
                since_start_ns: 0,
                boards: &[board(Outcome::Fresh)],
            });
        }
        let refused = UdpStream::to("no-port", Calibration::default()).unwrap_err().to_string();
        assert!(refused.starts_with("no-port: "), "{refused}");
    }
}
