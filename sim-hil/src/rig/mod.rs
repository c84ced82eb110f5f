//! A whole rig in virtual time: boards on one bus, the truth plant behind them, faults in between.
//!
//! ```
//! use pneudrive_protocol::{Address, Counts, Packet};
//! use pneudrive_sim::rig::RigOptions;
//!
//! let mut rig = RigOptions { boards: 2, strict: true, ..RigOptions::default() }.build()?;
//! let request = Packet { address: Address::of_board(1), values: [Counts::ATMOSPHERE; 4] };
//! rig.send(5_000_000, &request.encode()); // at 5 ms
//! rig.run_until(6_000_000);
//! let heard: Vec<_> = std::iter::from_fn(|| rig.receive()).collect();
//! assert_eq!(heard.len(), 10);
//! // Ten characters of 10 us there, 15 us of turnaround, ten characters back.
//! assert_eq!(heard[9].at_ns, 5_215_000);
//! # Ok::<(), pneudrive_sim::rig::RigError>(())
//! ```

mod error;
mod options;

pub use error::RigError;
pub use options::{Firmware, RigOptions, Timing};
