//! The Foxglove layout in docs/ shows what is in our bags.

use crate::support::answer;
use crate::support::virtual_line::{AT_ONCE, VirtualLine};
use byteorder::LittleEndian;
use pneudrive_host::bus::{Bus, BusOptions, EchoMode, FormatPolicy};
use pneudrive_host::poller::{PollerOptions, Polling, SetPoints, SourceStatus};
use pneudrive_protocol::{Echo, SensorScale};
use pneudrive_record::Recorder;
use pneudrive_record::messages::JointState;
use serde_json::Value;
use std::collections::BTreeMap;

const LAYOUT: &str = include_str!("../../../docs/foxglove.json");

/// Names of the values of every topic of a bag of four boards; without names those that have none.
fn topics() -> BTreeMap<String, Vec<String>> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let line = VirtualLine::new(|_, request| vec![(AT_ONCE, answer(0xFF - request[1], 300))]);
    let options = BusOptions::default().formats(FormatPolicy::Unchecked).echo(EchoMode::Known(Echo::Absent));
    let polled = PollerOptions::for_devices(4);
    let (recorder, tap) = Recorder::create(&file, &polled.boards, SensorScale::ORIGINAL, false).unwrap();
    let bus = Bus::new(line, options).unwrap();
    let mut polling = Polling::new(bus, polled, Box::new(SetPoints::new(4)), vec![tap]);
    (0..5).for_each(|_| assert_eq!(polling.cycle().unwrap(), SourceStatus::Continues));
    drop(polling);
    recorder.finish().unwrap();
    let stored = std::fs::read(&file).unwrap();
    let summary = mcap::Summary::read(&stored).unwrap().unwrap();
    let mut topics: BTreeMap<String, Vec<String>> =
        summary.channels.values().map(|channel| (channel.topic.clone(), Vec::new())).collect();
    for message in mcap::MessageStream::new(&stored).unwrap() {
        let message = message.unwrap();
        if message.channel.schema.as_ref().unwrap().name == JointState::ROS_TYPE {
            let (state, _) =
                cdr_encoding::from_bytes::<JointState, LittleEndian>(&message.data[4..]).unwrap();
            topics.insert(message.channel.topic.clone(), state.name);
        }
    }
    topics
}

/// The panels that a node of the layout's tree holds.
fn panels<'a>(node: &'a Value, into: &mut Vec<&'a str>) {
    match node.as_str() {
        Some(panel) => into.push(panel),
        None => ["first", "second"].iter().for_each(|side| panels(&node[side], into)),
    }
}

#[test]
fn every_plot_of_the_layout_is_of_a_value_that_bags_have_and_every_panel_has_a_place() {
    let layout: Value = serde_json::from_str(LAYOUT).unwrap();
    let topics = topics();
    let configured = layout["configById"].as_object().unwrap();
    let mut placed = Vec::new();
    panels(&layout["layout"], &mut placed);
    placed.sort_unstable();
    assert!(placed.iter().eq(configured.keys()), "{placed:?}");
    let mut shown = Vec::new();
    for (panel, config) in configured {
        if panel.starts_with("RosOut!") {
            assert!(topics.contains_key(config["topicToRender"].as_str().unwrap()), "{config}");
            continue;
        }
        for path in config["paths"].as_array().unwrap() {
            let value = path["value"].as_str().unwrap();
            let (topic, index) = value.split_once(".effort[").unwrap();
            let index: usize = index.strip_suffix(']').unwrap().parse().unwrap();
            assert_eq!(topics[topic][index], path["label"], "{value}");
            shown.push(topics[topic][index].clone());
        }
    }
    // All pressures and all commands, each once.
    let states = topics.iter().filter(|(topic, _)| topic.ends_with("pressure_state"));
    let mut there: Vec<_> = states.flat_map(|(_, names)| names.clone()).collect();
    there.sort_unstable();
    shown.sort_unstable();
    assert_eq!(shown, there);
}

/// The keys of `object` that are not in `known`.
fn unknown<'a>(object: &'a Value, known: &[&str]) -> Vec<&'a String> {
    object.as_object().unwrap().keys().filter(|key| !known.contains(&key.as_str())).collect()
}

/// Types of the layout as Lichtblick declares them, which is the last open version of Foxglove and
/// reads the same files: `LayoutData`, `PlotConfig` and `PlotPath` (panels/Plot/utils/config.ts),
/// the log panel's `Config` (panels/Log), and the tree of react-mosaic.
#[test]
fn the_layout_has_the_types_that_its_readers_declare() {
    let layout: Value = serde_json::from_str(LAYOUT).unwrap();
    let parts = ["configById", "globalVariables", "userNodes", "playbackConfig", "layout"];
    assert!(unknown(&layout, &parts).is_empty());
    assert!(parts.iter().all(|part| !layout[part].is_null()));
    assert!(layout["playbackConfig"]["speed"].is_number());
    tree(&layout["layout"]);
    for (panel, config) in layout["configById"].as_object().unwrap() {
        // Each of the two readers has its own key.
        assert!(config["foxglovePanelTitle"].is_string(), "{panel}");
        assert_eq!(config["foxglovePanelTitle"], config["lichtblickPanelTitle"], "{panel}");
        // The type of a panel is what stands before the `!`; that of the log panel has kept its old
        // name.
        match panel.split_once('!').unwrap().0 {
            "RosOut" => log(config),
            "Plot" => plot(config),
            other => panic!("no panel is of type {other}"),
        }
    }
}

/// A branch has a direction, two sides and the share of the first; a leaf is a panel.
fn tree(node: &Value) {
    if node.is_string() {
        return;
    }
    assert!(unknown(node, &["first", "second", "direction", "splitPercentage"]).is_empty(), "{node}");
    assert!(node["direction"] == "row" || node["direction"] == "column", "{node}");
    assert!((1.0..100.0).contains(&node["splitPercentage"].as_f64().unwrap()));
    tree(&node["first"]);
    tree(&node["second"]);
}

fn log(config: &Value) {
    let known = ["foxglovePanelTitle", "lichtblickPanelTitle", "searchTerms", "minLogLevel", "topicToRender"];
    assert!(unknown(config, &known).is_empty(), "{config}");
    assert!(config["searchTerms"].is_array() && config["minLogLevel"].is_u64());
}

fn plot(config: &Value) {
    let flags = ["showLegend", "showPlotValuesInLegend", "showXAxisLabels", "showYAxisLabels", "isSynced"];
    let others = [
        "foxglovePanelTitle",
        "lichtblickPanelTitle",
        "paths",
        "legendDisplay",
        "xAxisVal",
        "sidebarDimension",
    ];
    assert!(unknown(config, &[&flags[..], &others].concat()).is_empty(), "{config}");
    assert!(flags.iter().all(|flag| config[flag].is_boolean()), "{config}");
    assert!(["floating", "top", "left", "none"].contains(&config["legendDisplay"].as_str().unwrap()));
    assert!(
        ["timestamp", "index", "custom", "currentCustom"].contains(&config["xAxisVal"].as_str().unwrap())
    );
    assert!(config["sidebarDimension"].is_number());
    for path in config["paths"].as_array().unwrap() {
        let known = ["value", "enabled", "color", "label", "timestampMethod", "showLine", "lineSize"];
        assert!(unknown(path, &known).is_empty(), "{path}");
        assert!(path["enabled"].is_boolean());
        assert!(["receiveTime", "headerStamp"].contains(&path["timestampMethod"].as_str().unwrap()));
        let colour = path["color"].as_str().unwrap().strip_prefix('#').unwrap();
        assert!(matches!(colour.len(), 6 | 8) && u32::from_str_radix(colour, 16).is_ok(), "{path}");
    }
}
