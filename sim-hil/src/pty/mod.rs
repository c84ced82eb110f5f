//! The virtual bus behind a pseudo-terminal, paced to the wall clock. The only part of the crate
//! that reads a clock.
//!
//! # What the timing means
//!
//! A pty knows no baud rate (that its client sets 2 or 3 Mbaud is seen and taken for the adapter's
//! rate), and each of its two directions takes a detour through a kernel thread: a byte that one
//! side writes is seen by the other some 5 to 30 us later. A UART has no such detour on its way
//! out, and the wire starts when the host writes. So with
//! [`Timing::Wire`](crate::rig::Timing::Wire):
//!
//! 1. **Answers are never early.** The bytes of an answer are written to the pty when their last
//!    stop bit has ended in virtual time, and virtual time never runs ahead of the wall clock. What
//!    sleeping and scheduling add makes them late, never early; [`PaceReport`] says by how much.
//! 2. **The pty's detour is charged once, to nobody.** Its round trip (write, other side wakes and
//!    writes back, this side sees it) is measured at start, and a request is dated back by its
//!    median: [`RequestBackdating`]. So the first start bit falls when a client on a UART would
//!    have had it fall, as far as the simulator can know.
//! 3. **The simulator's own delay is the simulator's.** An answer that it hands over late (it woke
//!    late, or was busy with the plant) makes the client late by as much. The request that follows
//!    is dated back by that delay too: by what this one answer was late, not by an average, and
//!    only if the request is a reaction to it.
//! 4. **The wire stays half duplex.** A request is never dated before the end of what was last on
//!    the wire, nor before a time that the simulation has already passed; and by no more than eight
//!    characters in all.
//!
//! The consequence for a benchmark: a client pays for its own work and for scheduling beyond the
//! median, not for the pty. A client whose whole reaction, pty included, takes less than the median
//! round trip looks as if it had reacted at once; the speed measured is then the wire's.
//! `--pty-latency-us 0` switches point 2 off.
//!
//! The round trip holds more than a UART would not have: on its way in, a UART's bytes too pass
//! through the kernel's buffer and a wake-up before the client has them. How much of the round trip
//! that is cannot be seen from here; half is a fair guess, and `--pty-latency-us` with half of the
//! measured value charges it to the client.
//!
//! Two limits of this. The turnaround of the boards is part of an exchange: at 1 Mbaud the wire's
//! 5000/n Hz become 1e6/(215 n) Hz = 4651/n with the firmware's 15 us, whoever polls. And what the
//! kernel holds up is dated when it is seen: if a client gives up waiting and asks again while its
//! first request is still in a kernel queue, both arrive together, are put on the wire back to
//! back, and collide with the first answer. A machine too busy for its timeouts shows as
//! collisions.
//!
//! With [`Timing::Instant`](crate::rig::Timing::Instant) bytes take no time and are answered when
//! they are seen: what is measured is the host and the pty.
//!
//! A run of bytes is handed over together at its last stop bit, like a UART with a FIFO and an idle
//! timeout of nothing; `fifo` 1 hands over each byte by itself, at the price of ten wake-ups on
//! both sides.

mod backdating;
mod clock;
mod embedded;
mod error;
mod front_end;
mod output_fifo;
mod port;
mod report;
mod round_trip;
mod step_cost;

pub use backdating::{Delivery, RequestBackdating};
pub use embedded::EmbeddedSim;
pub use error::SimError;
pub use front_end::{FrontEnd, PtyOptions};
pub use port::VirtualPort;
pub use report::{PaceReport, SimReport};
pub use round_trip::measure_round_trip_ns;
