//! Rigs with firmware that cannot be built. Those that can run the real ELF in
//! `tests/tests/firmware/rig.rs`.

use pneudrive_protocol::Baud;
use pneudrive_sim::rig::{Firmware, RigError, RigOptions, Timing};

fn refusal(options: RigOptions) -> RigError {
    RigOptions { firmware: Some(Firmware::new(vec![0; 64])), ..options }.build().err().unwrap()
}

#[test]
fn what_firmware_cannot_do_is_refused() {
    let error = refusal(RigOptions { boards: 5, ..RigOptions::default() });
    assert!(matches!(error, RigError::FirmwareBoards { boards: 5 }), "{error}");
    let error = refusal(RigOptions { timing: Timing::Instant, ..RigOptions::default() });
    assert!(matches!(error, RigError::FirmwareTiming), "{error}");
    let error = refusal(RigOptions { baud: Baud::new(115_200).unwrap(), ..RigOptions::default() });
    assert!(matches!(error, RigError::FirmwareTiming), "{error}");
    let error = refusal(RigOptions::default());
    assert!(matches!(error, RigError::Firmware(_)), "{error}");
}
