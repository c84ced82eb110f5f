//! The Foxglove layout in docs/ shows what is in our bags.

#![cfg(feature = "cli")]
#![allow(clippy::unwrap_used)]

mod support;

use byteorder::LittleEndian;
use pneudrive_host::bus::{Bus, BusOptions, EchoMode, FrameMode};
use pneudrive_host::messages::JointState;
use pneudrive_host::poller::{PollerOptions, Polling, SetPoints, Supply};
use pneudrive_host::record::Recorder;
use pneudrive_protocol::{Echo, SensorScale};
use serde_json::Value;
use std::collections::BTreeMap;
use support::answer;
use support::virtual_line::{AT_ONCE, VirtualLine};

const LAYOUT: &str = include_str!("../../docs/foxglove.json");

/// Names of the values of every topic of a bag of four boards; without names those that have none.
fn topics() -> BTreeMap<String, Vec<String>> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let line = VirtualLine::new(|_, request| vec![(AT_ONCE, answer(0xFF - request[1], 300))]);
    let options = BusOptions {
        frames: FrameMode::Unchecked,
        echo: EchoMode::Known(Echo::Absent),
        ..BusOptions::default()
    };
    let polled = PollerOptions::for_devices(4);
    let (recorder, tap) = Recorder::create(&file, &polled.boards, SensorScale::ORIGINAL, false).unwrap();
    let bus = Bus::new(line, options).unwrap();
    let mut polling = Polling::new(bus, polled, Box::new(SetPoints::new(4)), vec![tap]);
    (0..5).for_each(|_| assert_eq!(polling.cycle().unwrap(), Supply::Continues));
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
