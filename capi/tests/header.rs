//! `include/pneudrive.h` says what the library has: it is what cbindgen makes of the sources.
//!
//! `PNEUDRIVE_WRITE_HEADER=1 cargo test -p pneudrive-capi --test integration header::` writes it.

use std::path::Path;

#[test]
fn the_header_is_that_of_the_sources() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).unwrap();
    let mut builder = cbindgen::Builder::new().with_config(config);
    for source in ["abi.rs", "channel.rs", "inputs.rs", "outputs.rs", "partials.rs"] {
        builder = builder.with_src(folder.join("src").join(source));
    }
    let mut made = Vec::new();
    builder.generate().unwrap().write(&mut made);
    let made = String::from_utf8(made).unwrap();
    let header = folder.join("include/pneudrive.h");
    if std::env::var_os("PNEUDRIVE_WRITE_HEADER").is_some() {
        std::fs::write(&header, &made).unwrap();
    }
    let kept = std::fs::read_to_string(&header).unwrap();
    assert!(made == kept, "write it anew with PNEUDRIVE_WRITE_HEADER=1; it would be\n{made}");
}
