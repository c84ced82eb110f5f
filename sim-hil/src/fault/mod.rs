//! Faults between host and boards: each by name, with a rate or at a time, seeded, and counted when
//! it takes effect.
//!
//! ```text
//!  host --- adapter ----------------- pair ------------------- boards
//!           bit_flip drop duplicate   stray noise              unplug babble power_cycle
//!           delay echo
//! ```
//!
//! - Faults of the **adapter** act on single characters, on the way to the pair (`on=requests`),
//!   from it (`on=answers`) or both. A dropped request byte is never on the wire; a dropped answer
//!   byte is, but not at the host.
//! - Faults of the **pair** are heard by everybody and fall on whatever is being said.
//! - Faults of a **board** last for a while.
//!
//! [`FaultKind::ALL`] is the list with units and examples; [`FaultSpec`] parses one;
//! [`FaultInjector`] runs them.

mod adapter;
mod episode;
mod error;
mod injector;
mod kind;
mod spec;

pub use error::FaultError;
pub use injector::{FaultInjector, LineEvent, Passage};
pub use kind::FaultKind;
pub use spec::{FaultSpec, Path, When};
