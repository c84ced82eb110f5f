//! Boards of a program without the simulator: there are none.

use crate::{VirtualError, VirtualOptions};
use std::path::Path;
use std::time::Duration;

#[derive(Debug)]
pub(crate) enum Boards {}

impl Boards {
    pub(crate) fn start(_: &VirtualOptions) -> Result<Self, VirtualError> {
        Err(VirtualError::NotBuilt)
    }

    pub(crate) fn path(&self) -> &Path {
        match *self {}
    }

    pub(crate) fn pty_round_trip(&self) -> Duration {
        match *self {}
    }
}
