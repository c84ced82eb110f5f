//! Where results go: what a command reads is not replaced, and what cannot be written is said
//! before any work.

use std::os::unix::fs::OpenOptionsExt;
use std::process::{Command, Stdio};

use crate::command_line::lag;
use crate::common::Folder;
use crate::common::cli::run;

/// A recording, a fit of it, and a rig file.
fn fitted() -> Folder {
    let folder = Folder::new();
    folder.write("lag.csv", lag().as_bytes());
    folder.write("rig.toml", b"[supply]\npressure_kpa = 550.0\n");
    let fit = ["fit", "lag.csv", "--model", "linear", "--starts", "1", "--out", "p.toml"];
    assert_eq!(run(folder.root(), &fit).status, 0);
    folder
}

#[test]
fn what_is_read_is_never_replaced() {
    let folder = fitted();
    std::fs::create_dir(folder.path("d")).unwrap();
    std::fs::copy(folder.path("p.toml"), folder.path("d/extended.toml")).unwrap();
    std::fs::copy(folder.path("p.toml"), folder.path("d/parameters.toml")).unwrap();
    std::os::unix::fs::symlink(folder.path("lag.csv"), folder.path("link.csv")).unwrap();
    let content = |name: &str| std::fs::read(folder.path(name)).unwrap();
    let inputs = ["lag.csv", "rig.toml", "p.toml", "d/extended.toml", "d/parameters.toml"];
    let before = inputs.map(content);
    for arguments in [
        "fit lag.csv --rig rig.toml --model linear --out rig.toml",
        "fit p.toml --model linear --out p.toml",
        "simulate lag.csv --parameters p.toml --out lag.csv",
        "simulate lag.csv --parameters p.toml --out link.csv",
        "simulate lag.csv --parameters p.toml --out s.csv --band ./lag.csv",
        "show lag.csv --out lag.csv",
        "show lag.csv --rig rig.toml --out d/../rig.toml",
        "import lag.csv --time t_s:s --map b0_p0_kpa=b0_p0_kpa:kPa --out lag.csv",
        "diagnose lag.csv --reference d/extended.toml --out d",
        "diagnose lag.csv --machine d/extended.toml --out d",
        "export jax --parameters d/parameters.toml --out d",
        "export fmu --parameters p.toml --out p.toml",
    ] {
        let done = run(folder.root(), &arguments.split(' ').collect::<Vec<_>>());
        assert_eq!(done.status, 2, "{arguments}: {}", done.stderr);
        assert!(
            done.stderr.contains("that file is read here; choose another name"),
            "{arguments}: {}",
            done.stderr
        );
    }
    assert_eq!(inputs.map(content), before);
}

#[test]
fn where_nothing_can_be_written_is_said_before_any_work() {
    let folder = fitted();
    let before = folder.names();
    for (arguments, said) in [
        ("fit lag.csv --model linear --out no/such/p.toml", "there is no folder no/such; make it first"),
        ("fit lag.csv --model linear --out .", "that is a folder; name a file in it"),
        ("fit lag.csv --model linear --out p.json", "let the name end in .toml"),
        ("fit lag.csv --model linear --out b.csv", "let the name end in .toml"),
        ("simulate lag.csv --parameters p.toml --out s.txt", "let the name end in .csv, .csv.gz or .csv.zst"),
        ("show lag.csv --out no/page.html", "there is no folder no; make it first"),
        ("compare lag.csv --models linear --out lag.csv", "lag.csv is a file; name a folder"),
        ("diagnose lag.csv --out p.toml/d", "p.toml is a file; name a folder"),
        ("diagnose lag.csv --out /proc/none", "nothing can be written there"),
    ] {
        let done = run(folder.root(), &arguments.split(' ').collect::<Vec<_>>());
        assert_eq!(done.status, 2, "{arguments}: {}", done.stderr);
        assert!(done.stderr.contains(said), "{arguments}: {}", done.stderr);
        // The recording was not even read.
        assert!(!done.stderr.contains("rows"), "{arguments}: {}", done.stderr);
        assert_eq!(folder.names(), before, "{arguments}");
    }
}

/// `pneudrive-model .. | head -0`, and a disk that is full.
#[test]
fn a_closed_output_ends_nothing_and_a_full_one_is_said() {
    let folder = fitted();
    let program = || {
        let mut program = Command::new(env!("CARGO_BIN_EXE_pneudrive-model"));
        program.current_dir(folder.root()).stderr(Stdio::piped());
        program
    };
    for arguments in ["fit lag.csv --model linear --starts 1 --out q.toml", "effects", "show lag.csv"] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let done = program().args(arguments.split(' ')).stdout(writer).output().unwrap();
        assert_eq!(done.status.code(), Some(0), "{arguments}: {}", String::from_utf8_lossy(&done.stderr));
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let done = program().args(arguments.split(' ')).stdout(full).output().unwrap();
        let said = String::from_utf8_lossy(&done.stderr);
        assert_eq!(done.status.code(), Some(1), "{arguments}: {said}");
        assert!(said.contains("error: standard output: No space left"), "{arguments}: {said}");
    }
    assert!(folder.path("q.toml").exists() && folder.path("lag.html").exists());
}

#[test]
fn a_recording_is_diagnosed_once() {
    let folder = fitted();
    std::fs::copy(folder.path("lag.csv"), folder.path("copy.csv")).unwrap();
    for loads in ["auto", "same"] {
        let done = run(folder.root(), &["diagnose", "lag.csv", "copy.csv", "--loads", loads, "--out", "d"]);
        assert_eq!(done.status, 2, "{loads}: {}", done.stderr);
        assert!(
            done.stderr
                .contains("copy.csv is lag.csv once more (the same SHA-256): give each recording once"),
            "{loads}: {}",
            done.stderr
        );
    }
}

#[test]
fn what_no_fit_finds_is_not_simulated() {
    let folder = fitted();
    let found = std::fs::read_to_string(folder.path("p.toml")).unwrap();
    let (before, value) = found.split_once("name = \"alpha\"\nvalue = ").unwrap();
    let rest = value.split_once('\n').unwrap().1;
    let out = ["--out", "s.csv"];
    for wrong in ["-5.0", "0.0", "1e300"] {
        folder.write("wrong.toml", format!("{before}name = \"alpha\"\nvalue = {wrong}\n{rest}").as_bytes());
        let done =
            run(folder.root(), &[&["simulate", "lag.csv", "--parameters", "wrong.toml"][..], &out].concat());
        assert_eq!(done.status, 2, "{wrong}: {}", done.stderr);
        assert!(done.stderr.contains("channel b0c0: parameter alpha is"), "{wrong}: {}", done.stderr);
    }
    for start in ["nan", "-5000", "1e300"] {
        let start = ["simulate", "lag.csv", "--parameters", "p.toml", "--start-kpa", start];
        let done = run(folder.root(), &[&start[..], &out].concat());
        assert!(done.status == 2 && done.stderr.contains("-101 to 10000 kPa gauge"), "{}", done.stderr);
    }
}

/// The same command's own results may be.
#[test]
fn recordings_and_rig_files_are_not_replaced_by_results() {
    let folder = fitted();
    std::fs::copy(folder.path("lag.csv"), folder.path("other.csv")).unwrap();
    let content = |name: &str| std::fs::read(folder.path(name)).unwrap();
    let before = ["other.csv", "rig.toml"].map(content);
    let import = "import lag.csv --time t_s:s --map b0_p0_kpa=b0_p0_kpa:kPa --out other.csv";
    for (arguments, said) in [
        ("simulate lag.csv --parameters p.toml --out other.csv", "was not written by this command"),
        ("fit lag.csv --model linear --out rig.toml", "was not written by this command"),
        (import, "other.csv exists; choose another name, or pass --overwrite"),
    ] {
        let done = run(folder.root(), &arguments.split(' ').collect::<Vec<_>>());
        assert_eq!(done.status, 2, "{arguments}: {}", done.stderr);
        assert!(done.stderr.contains(said), "{arguments}: {}", done.stderr);
    }
    assert_eq!(["other.csv", "rig.toml"].map(content), before);
    for arguments in
        [format!("{import} --overwrite"), "fit lag.csv --model linear --starts 1 --out p.toml".to_owned()]
    {
        let done = run(folder.root(), &arguments.split(' ').collect::<Vec<_>>());
        assert_eq!(done.status, 0, "{arguments}: {}", done.stderr);
    }
}

/// `fit`, `simulate` and `show` name their JSON after another file, which two of them may share.
#[test]
fn what_another_command_wrote_is_not_replaced() {
    let folder = fitted();
    let done = |arguments: &str| run(folder.root(), &arguments.split(' ').collect::<Vec<_>>());
    let simulate = "simulate lag.csv --parameters p.toml --out s.csv";
    assert_eq!(done(simulate).status, 0);
    let before = std::fs::read(folder.path("s.json")).unwrap();
    for arguments in ["show s.csv", "fit s.csv --model linear --out s.toml"] {
        let refused = done(arguments);
        assert_eq!(refused.status, 2, "{arguments}: {}", refused.stderr);
        assert!(refused.stderr.contains("s.json: something else is in that file"), "{}", refused.stderr);
    }
    assert_eq!(std::fs::read(folder.path("s.json")).unwrap(), before);
    assert!(!folder.path("s.html").exists() && !folder.path("s.toml").exists());
    assert_eq!(done("show s.csv --out page.html").status, 0);
    assert_eq!(done(simulate).status, 0, "its own may be replaced");
}

#[test]
fn a_fit_that_was_stopped_is_not_used_without_a_word() {
    let folder = fitted();
    let whole = std::fs::read_to_string(folder.path("p.toml")).unwrap();
    assert!(whole.contains("stopped = false"));
    folder.write("q.toml", whole.replace("stopped = false", "stopped = true").as_bytes());
    let warning = "q.toml: its fit was stopped before it ended";
    for arguments in [
        "simulate lag.csv --parameters q.toml --out s.csv",
        "export jax --parameters q.toml --out jax",
        "watch lag.csv --parameters q.toml",
    ] {
        let done = run(folder.root(), &arguments.split(' ').collect::<Vec<_>>());
        assert!(done.stderr.contains(warning), "{arguments}: {}", done.stderr);
        let done = run(folder.root(), &arguments.replace("q.toml", "p.toml").split(' ').collect::<Vec<_>>());
        assert!(!done.stderr.contains(warning), "{arguments}: {}", done.stderr);
    }
}

/// Of Linux on all that we run on.
const O_NONBLOCK: i32 = 0o4000;

/// Its results come at its end alone.
#[test]
fn a_diagnosis_that_is_stopped_says_so() {
    let folder = fitted();
    assert!(Command::new("mkfifo").arg(folder.path("pipe.csv")).status().unwrap().success());
    let mut child = Command::new(env!("CARGO_BIN_EXE_pneudrive-model"))
        .args(["diagnose", "pipe.csv", "--rig", "rig.toml", "--out", "d"])
        .current_dir(folder.root())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let pipe = loop {
        // Without waiting: an error until the program reads, and it listens to signals by then.
        match std::fs::File::options().write(true).custom_flags(O_NONBLOCK).open(folder.path("pipe.csv")) {
            Ok(pipe) => break pipe,
            Err(_) => std::thread::sleep(std::time::Duration::from_millis(10)),
        }
        assert!(child.try_wait().unwrap().is_none(), "ended before it read");
    };
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let status = child.wait().unwrap();
    drop(pipe);
    let mut said = String::new();
    std::io::Read::read_to_string(&mut child.stderr.take().unwrap(), &mut said).unwrap();
    assert_eq!(status.code(), Some(1), "{said}");
    assert!(said.contains("interrupted; there are no results yet"), "{said}");
    assert!(!folder.path("d").exists());
}
