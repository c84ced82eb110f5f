use super::*;
use clap::CommandFactory;

fn settings(line: &str) -> Result<Settings, ArgsError> {
    Settings::from_command_line(format!("x {line}").split_whitespace().map(OsString::from))
}

#[test]
fn the_arguments_are_consistent() {
    Flags::command().debug_assert();
}

/// Help is 100 wide where it is not read on a terminal, and an example that is broken cannot be
/// copied.
#[test]
fn examples_of_the_help_are_whole_lines() {
    let help = Flags::command().get_after_help().unwrap().to_string();
    let examples: Vec<_> = help.lines().filter(|line| line.starts_with("  ")).collect();
    let broken: Vec<_> = examples.iter().filter(|line| line.chars().count() > 100).collect();
    assert!(examples.len() > 3 && broken.is_empty(), "{broken:#?}");
}

#[test]
fn parameters_are_flags() {
    let line = "--ros-args -p port:=['/dev/a','/dev/b'] -p devices:=[4,2] -p rate_hz:=500.0 -r __ns:=/arm";
    let settings = settings(line).unwrap();
    assert_eq!(settings.flags.port, [PathBuf::from("/dev/a"), PathBuf::from("/dev/b")]);
    assert_eq!((settings.devices(0), settings.devices(1)), (4, 2));
    assert_eq!(settings.flags.rate_hz, Some(500.0));
    assert_eq!(settings.names.full(), "/arm/pneudrive");
}

/// As launch files do, which put parameters behind flags. Only ports add up: each is a bus.
#[test]
fn the_last_word_counts_and_ports_add_up() {
    let settings = settings("--port a,b --rate-hz 100 --port c --ros-args -p rate_hz:=200.0").unwrap();
    assert_eq!(settings.flags.port, ["a", "b", "c"].map(PathBuf::from));
    assert_eq!(settings.flags.rate_hz, Some(200.0));
}

/// A file is the farthest away: flags win over it, and parameters on the command line over both.
#[test]
fn files_of_parameters_come_before_flags() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("params.yaml");
    let text = "/**:\n  ros__parameters: {port: [/dev/f, /dev/g], devices: [3, 2], rate_hz: 0.0, rig: '', use_sim_time: false}\n\
                /arm/air:\n  ros__parameters: {max_kpa: 200.0, watchdog_s: 3.0}\n/other:\n  ros__parameters: {devices: 9}\n";
    std::fs::write(&file, text).unwrap();
    let file = file.display();
    let of = |line: &str| {
        let flags = settings(line).unwrap().flags;
        (flags.port, flags.devices, flags.max_kpa, flags.watchdog_s)
    };
    let ports = |ports: &[&str]| ports.iter().map(PathBuf::from).collect::<Vec<_>>();
    let alone = of(&format!("--ros-args --params-file {file}"));
    assert_eq!(alone, (ports(&["/dev/f", "/dev/g"]), vec![3, 2], None, 1.0));
    let named = of(&format!("--name air --ros-args -r __ns:=/arm --params-file {file}"));
    assert_eq!((named.2, named.3), (Some(200.0), 3.0));
    let flags = of(&format!("--port /dev/a -n 1 --ros-args --params-file {file}"));
    assert_eq!((flags.0, flags.1), (ports(&["/dev/a"]), vec![1]));
    let last =
        of(&format!("--port /dev/a -n 1 --ros-args --params-file {file} -p port:=/dev/p -p devices:=[4]"));
    assert_eq!((last.0, last.1), (ports(&["/dev/p"]), vec![4]));
    let refused = |line: &str| settings(line).unwrap_err().to_string();
    assert!(refused("--port a --ros-args --params-file /nowhere.yaml").contains("/nowhere.yaml"));
    assert!(refused("--port a --overwrite").contains("give --record"));
}

#[test]
fn what_cannot_be_is_refused() {
    let refused = |line: &str| settings(line).unwrap_err().to_string();
    assert!(refused("--port a,b,c --devices 4,2").contains("each of the 3 ports"));
    assert!(refused("--port a,b --watch x.toml").contains("one file for each of the 2 ports"));
    assert!(refused("--port a --rate-hz 0").contains("--rate-hz 0: must be above 0"));
    assert!(refused("--port a --max-command-age-s NaN").contains("at least 0"));
    assert!(refused("--port a --message-type a/b/c").contains("PACKAGE/TYPE"));
}

/// Whoever wants commands to hold for ever says so.
#[test]
fn commands_expire_by_default() {
    let timeout_s = |line: &str| settings(line).unwrap().flags.command_timeout_s;
    assert_eq!(timeout_s("--port a"), 0.5);
    assert_eq!(timeout_s("--port a --command-timeout-s 2.5"), 2.5);
    for never in
        ["--command-timeout-s never", "--command-timeout-s 0", "--ros-args -p command_timeout_s:=never"]
    {
        assert_eq!(timeout_s(&format!("--port a {never}")), 0.0);
    }
}

#[test]
fn limits_come_from_flags_and_rig_file_and_the_strictest_holds() {
    let folder = tempfile::tempdir().unwrap();
    let rig = folder.path().join("rig.toml");
    std::fs::write(&rig, "[boards.1.limits]\nmax_kpa = 100.0\n").unwrap();
    let line =
        format!("--port a -n 2 --max-kpa 300 --ros-args -p max_rate_kpa_s:=50.0 -p rig:={}", rig.display());
    let limits = settings(&line).unwrap().limits;
    let limit = |max_kpa| ChannelLimit { max_kpa, max_rate_kpa_s: 50.0 };
    assert_eq!((limits.of(0)[0], limits.of(1)[3]), (limit(300.0), limit(100.0)));
    let refused = |line: &str| settings(line).unwrap_err().to_string();
    assert!(refused("--port a --max-kpa -1").contains("a highest pressure of -1 kPa"));
    assert!(refused("--port a --rig /nowhere.toml").contains("/nowhere.toml"));
}

#[test]
fn limits_of_a_board_that_is_not_polled_are_refused_unless_flags_leave_it_out() {
    let folder = tempfile::tempdir().unwrap();
    let rig = folder.path().join("rig.toml");
    std::fs::write(&rig, "[bus]\nboards = 1\n[boards.1.limits]\nmax_kpa = 50.0\n").unwrap();
    let settings = |line: &str| settings(&format!("--port a,b --rig {} {line}", rig.display()));
    let refused = settings("").unwrap_err().to_string();
    assert!(refused.contains("[boards.1] has limits, but [bus] boards = 1 means board 0 alone"), "{refused}");
    // Of several buses the longest counts.
    for line in ["-n 1", "-n 1,2"] {
        assert!(settings(line).is_ok(), "{line}");
    }
}

#[test]
fn more_boards_than_a_switch_tells_apart_have_to_be_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let rig = folder.path().join("rig.toml");
    std::fs::write(&rig, "[bus]\nboards = 9\n").unwrap();
    let of_file = format!("--port a --rig {}", rig.display());
    for line in ["--port a -n 9", "--port a,b -n 4,5", &of_file] {
        let refused = settings(line).unwrap_err().to_string();
        assert!(
            refused.contains("must be 1 to 4; boards with more than a two-way address switch need"),
            "{refused}"
        );
        assert!(settings(&format!("{line} --max-devices 9")).is_ok(), "{line}");
    }
}

#[test]
fn a_rig_file_says_what_the_flags_do_not() {
    let folder = tempfile::tempdir().unwrap();
    let rig = folder.path().join("rig.toml");
    let text = "[bus]\nport = \"/dev/a\"\nboards = 3\nrate_hz = 250\n\
                [boards.1.channels.2.sensor]\nzero_counts = 110.0\nkpa_per_count = 0.9\n";
    std::fs::write(&rig, text).unwrap();
    let settings = |line: &str| settings(&format!("--rig {} {line}", rig.display())).unwrap();
    let all = settings("");
    assert_eq!((&all.flags.port, all.devices(0)), (&vec![PathBuf::from("/dev/a")], 3));
    assert_eq!((all.flags.rate_hz, all.baud()), (Some(250.0), BaudChoice::Rate(1_000_000)));
    assert_eq!(all.calibration.channel(1, 2).zero_counts(), 110.0);
    std::fs::write(&rig, text.replace("rate_hz = 250", "baud = \"auto\"")).unwrap();
    assert_eq!(settings("").baud(), BaudChoice::Auto);
    assert_eq!(settings("--baud 500000").baud(), BaudChoice::Rate(500_000));
    let some = settings("--port b -n 2 --rate-hz 100");
    assert_eq!((&some.flags.port, some.devices(0)), (&vec![PathBuf::from("b")], 2));
    assert_eq!(some.flags.rate_hz, Some(100.0));
}

#[test]
fn the_originals_message_goes_by_any_name() {
    let message = settings("--port a --message-type arm_msgs/Pressures").unwrap().message;
    assert_eq!(message, MessageType::Pressures { package: "arm_msgs".into(), name: "Pressures".into() });
}
