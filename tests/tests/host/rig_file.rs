//! One rig file for the whole system: what the host takes from it and what the toolkit takes are
//! the same numbers.

use pneudrive_model::data::ChannelId;
use pneudrive_model::rig::Rig as ModelRig;
use pneudrive_rig::Rig;

const PAGE: &str = include_str!("../../../docs/rig.md");

#[test]
fn the_documented_example_means_the_same_to_both() {
    let example = PAGE.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let host = Rig::parse("rig.toml", example).unwrap();
    let model = ModelRig::parse("rig.toml", example).unwrap();
    assert_eq!(host.number("supply.pressure_kpa"), model.supply.as_ref().map(|supply| supply.pressure_kpa));
    // The strictest limit of any channel bounds what experiments command.
    assert_eq!(model.highest_set_point_kpa, host.limit(0, 3).max_kpa);
    for (board, channel) in [(0, 3), (0, 0), (1, 3)] {
        let here = model.at(ChannelId { board, channel });
        let places =
            [format!("boards.{board}.channels.{channel}."), format!("boards.{board}."), String::new()];
        let nearest = |key: &str| places.iter().find_map(|place| host.number(&format!("{place}{key}")));
        // The nearest table holds as a whole: this one has another description of the chamber.
        let volume = (board, channel) == (0, 3);
        let chamber = here.chamber.unwrap();
        assert_eq!(chamber.length_m, nearest("chamber.length_m").filter(|_| !volume));
        assert_eq!(chamber.volume_m3, nearest("chamber.volume_m3").filter(|_| volume));
        assert_eq!(Some(here.valve.unwrap().critical_ratio), nearest("valve.critical_ratio"));
        assert_eq!(Some(here.controller.unwrap().kp), nearest("controller.kp"));
        // The host's own way to the same calibration.
        let calibration = host.sensor(board, usize::from(channel)).unwrap();
        let sensor = here.sensor.unwrap();
        assert_eq!(
            (sensor.zero_counts, sensor.kpa_per_count),
            (calibration.zero_counts, calibration.kpa_per_count)
        );
    }
}
