//! Where the same test bodies run: on virtual boards behind a pty, or on real ones.
//!
//! With `--features hardware` they run on the port that PNEUDRIVE_PORT names, with
//! PNEUDRIVE_DEVICES boards (default 1).

use pneudrive_host::bus::{Bus, BusOptions};
use std::time::Duration;

#[cfg(not(feature = "hardware"))]
pub struct Target {
    sim: pneudrive_sim::pty::EmbeddedSim,
    pub devices: u16,
}

#[cfg(not(feature = "hardware"))]
impl Target {
    /// As many virtual boards as the test would like.
    pub fn start(devices: u16) -> Self {
        use pneudrive_sim::pty::{EmbeddedSim, PtyOptions};
        use pneudrive_sim::rig::RigOptions;
        let rig = RigOptions { boards: usize::from(devices), ..RigOptions::default() };
        Self { sim: EmbeddedSim::start(&rig, &PtyOptions::default()).unwrap(), devices }
    }

    pub fn path(&self) -> &std::path::Path {
        self.sim.path()
    }

    /// A bus with patience: the machine that runs the tests may be busy with other things.
    pub fn bus(&self) -> Bus {
        let options = BusOptions::default().answer_allowance(Duration::from_secs(10));
        Bus::open(self.path(), options).unwrap()
    }
}

#[cfg(feature = "hardware")]
pub struct Target {
    path: std::path::PathBuf,
    pub devices: u16,
}

#[cfg(feature = "hardware")]
impl Target {
    /// The boards there are, however many the test would like.
    pub fn start(_: u16) -> Self {
        let path = std::env::var_os("PNEUDRIVE_PORT").expect("PNEUDRIVE_PORT names the serial port").into();
        let devices = std::env::var("PNEUDRIVE_DEVICES").map_or(1, |text| text.parse().unwrap());
        Self { path, devices }
    }

    pub fn path(&self) -> &std::path::Path {
        &self.path
    }

    pub fn bus(&self) -> Bus {
        Bus::open(self.path(), BusOptions::default()).unwrap()
    }
}
