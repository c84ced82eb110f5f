//! Recordings and rig files as users write them.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod data_errors;
mod data_quality;
// The toolkit's tests have the same need.
#[path = "../../cli/tests/common/folder.rs"]
mod folder;
mod rig_file;

fn gzip(content: &[u8]) -> Vec<u8> {
    use std::io::Write as _;
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(content).expect("memory");
    encoder.finish().expect("memory")
}
