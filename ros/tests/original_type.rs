//! The original project's message, `{Header header, float64[] pressure}`, under a package's name
//! that no ROS installation here knows: the peer is the same DDS library.

#![allow(clippy::unwrap_used)]
#![cfg(feature = "sim")]

use pneudrive_record::messages::{Header, Pressures, Time};
use ros2_client::qos::QosProfile;
use ros2_client::{Context, ContextOptions, MessageTypeName, Name, NodeName, NodeOptions};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Ends the node when the test ends, however.
struct Node(Child);

impl Drop for Node {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn the_originals_message_goes_both_ways() {
    let domain_id = 101 + (std::process::id() % 100) as u16;
    let mut node = Command::new(env!("CARGO_BIN_EXE_pneudrive-ros"));
    node.args(["--port", "sim", "--rate-hz", "200", "--message-type", "arm_msgs/Pressures"]);
    node.args(["--domain-id", &domain_id.to_string(), "--namespace", "/arm"]).stdin(Stdio::null());
    let _node = Node(node.spawn().unwrap());

    let context = Context::with_options(ContextOptions::new().domain_id(domain_id)).unwrap();
    let mut peer = context.new_node(NodeName::new("/", "peer").unwrap(), NodeOptions::new()).unwrap();
    let topic = |peer: &ros2_client::Node, name: &str, qos: &QosProfile| {
        let name = Name::parse(&format!("/arm/pneudrive/joint_0/{name}")).unwrap();
        peer.create_topic(&name, MessageTypeName::new("arm_msgs", "Pressures"), qos).unwrap()
    };
    let state_topic = topic(&peer, "pressure_state", &QosProfile::subscription_default());
    let states = peer.create_subscription::<Pressures>(&state_topic, None).unwrap();
    let command_topic = topic(&peer, "pressure_command", &QosProfile::publisher_default());
    let commands = peer.create_publisher::<Pressures>(&command_topic, None).unwrap();

    let started = Instant::now();
    let mut last = None;
    let mut arrived = false;
    while !arrived {
        assert!(started.elapsed() < Duration::from_secs(60), "the last state was {last:?}");
        let header = Header { stamp: Time::default(), frame_id: String::new() };
        commands.publish(Pressures { header, pressure: vec![10.0, 40.0, 70.0, 100.0] }).unwrap();
        std::thread::sleep(Duration::from_millis(20));
        while let Some((state, _)) = states.take().unwrap() {
            let near = |(measured, commanded): (&f64, f64)| (measured - commanded).abs() < 5.0;
            arrived = state.pressure.len() == 4
                && state.pressure.iter().zip([10.0, 40.0, 70.0, 100.0]).all(near)
                && !state.header.stamp.is_zero();
            last = Some(state);
        }
    }
}
