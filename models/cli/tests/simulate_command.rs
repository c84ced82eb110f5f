//! `pneudrive-model simulate` of a file of set points, which has a row where they change.

use crate::command_line::lag;
use crate::common::Folder;
use crate::common::cli::run;

#[test]
fn what_happens_between_two_set_points_is_simulated() {
    let folder = Folder::new();
    folder.write("lag.csv", lag().as_bytes());
    let fit = ["fit", "lag.csv", "--model", "linear", "--starts", "1", "--out", "p.toml"];
    assert_eq!(run(folder.root(), &fit).status, 0);
    folder.write("steps.csv", b"t_s,b0_cmd0_kpa\n0,0\n1,100\n1.5,100\n8,20\n9,20\n");
    let rows = |more: &[&str]| {
        let simulate = ["simulate", "steps.csv", "--parameters", "p.toml", "--out", "s.csv"];
        let done = run(folder.root(), &[&simulate[..], more].concat());
        assert_eq!(done.status, 0, "{}", done.stderr);
        assert!(!done.stderr.contains("gap"), "a set point holds until the next: {}", done.stderr);
        let text = std::fs::read_to_string(folder.path("s.csv")).unwrap();
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let header: Vec<String> = lines.next().unwrap().split(',').map(str::to_owned).collect();
        let at = |name: &str| header.iter().position(|column| column == name).unwrap();
        let places = ["t_s", "b0_cmd0_kpa", "b0_p0_kpa"].map(at);
        let numbers =
            |line: &str| -> Vec<f64> { line.split(',').map(|cell| cell.parse().unwrap()).collect() };
        lines.map(numbers).map(|row| places.map(|place| row[place])).collect::<Vec<_>>()
    };
    let hundred = rows(&[]);
    assert_eq!(hundred.len(), 901);
    let [t_s, command, before] = hundred[799];
    assert!((t_s - 7.99).abs() < 1e-9 && command == 100.0 && (before - 100.0).abs() < 1.0, "{before}");
    // It falls between the set point's row and the next, a second later.
    assert!(
        hundred[800..].windows(2).all(|two| two[1][2] <= two[0][2])
            && hundred[805][2] > hundred[880][2] + 1.0
    );
    assert_eq!(rows(&["--rate", "10"]).len(), 91);
    let done = run(
        folder.root(),
        &["simulate", "steps.csv", "--parameters", "p.toml", "--out", "s.csv", "--rate", "0"],
    );
    assert!(done.status == 2 && done.stderr.contains("--rate"), "{}", done.stderr);
}
