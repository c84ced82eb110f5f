//! `examples/step.c`, compiled as C11 and as C++ and run against the shared library.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::support::{Driven, extended, generator};
use pneudrive_capi::{Channel, Control};

/// Where the test and, beside it, the library is.
fn target() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().to_path_buf()
}

fn compile(compiler: &str, options: &[&str], out: &Path) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new(compiler)
        .args(options)
        .args(["-Wall", "-Wextra", "-Werror", "-O1"])
        .arg(folder.join("examples/step.c"))
        .arg("-I")
        .arg(folder.join("include"))
        .args(["-x", "none"])
        .arg("-L")
        .arg(target())
        .args(["-lpneudrive_capi", "-lm", "-o"])
        .arg(out)
        .output()
        .unwrap();
    assert!(output.status.success(), "{compiler}: {}", String::from_utf8_lossy(&output.stderr));
}

fn run(program: &Path, arguments: &[&str]) -> Output {
    Command::new(program).args(arguments).env("LD_LIBRARY_PATH", target()).output().unwrap()
}

#[test]
fn the_example_gives_the_librarys_numbers_and_refuses_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let parameters = folder.path().join("extended.toml");
    let file = extended(&mut generator(4), Driven::Board, 1, &["transport_delay"]);
    file.save(&parameters).unwrap();
    let name = parameters.to_str().unwrap();

    let mut channel = Channel::create(&parameters, "b0c0", 0.001, Control::SetPoint).unwrap();
    let mut inputs = *channel.nominal();
    channel.start(0.0, &inputs).unwrap();
    inputs.set_point_kpa = 150.0;
    let mut expected = "t_s,p_kpa,reading_kpa,drive\n".to_owned();
    for _ in 0..2000 {
        let o = channel.step(&inputs).unwrap();
        expected += &format!("{:.3},{:.6},{:.6},{:.4}\n", o.time_s, o.pressure_kpa, o.reading_kpa, o.drive);
    }

    for (compiler, options) in [("cc", ["-x", "c", "-std=c11"]), ("c++", ["-x", "c++", "-std=c++17"])] {
        let program = folder.path().join(compiler);
        compile(compiler, &options, &program);
        let output = run(&program, &[name, "b0c0", "150"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(
            String::from_utf8(output.stdout).unwrap().replace("-0.0000", "0.0000"),
            expected.replace("-0.0000", "0.0000")
        );
        let refused = run(&program, &[name, "b1c0", "150"]);
        let words = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(refused.status.code() == Some(2) && words.contains("no channel b1c0"), "{words}");
    }
}
