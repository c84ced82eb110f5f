//! The node's end towards DDS: topics, parameters, the thread that listens.

use crate::args::{MessageType, Settings};
use crate::channel_names::ChannelNames;
use crate::diagnostic_msgs::DiagnosticArray;
use crate::failure::Failure;
use crate::gate::CommandGate;
use crate::live::Live;
use crate::parameter_services::ParameterServices;
use crate::parameters;
use crate::pressure::{Part, PressureMessage};
use crate::publish::StateTopic;
use crate::sensors::SensorTopics;
use crate::services::{Services, Target};
use crate::unix_time::unix_now_ns;
use futures::StreamExt;
use futures::channel::oneshot;
use futures::executor::block_on;
use futures::future::{Either, join, select};
use futures::stream::SelectAll;
use pneudrive_record::messages::{FluidPressure, Imu, JointState, Log};
use ros2_client::qos::{Durability, History, QosProfile, Reliability, WhenFull};
use ros2_client::{Context, ContextOptions, MessageTypeName, Name, Node, Publisher, Subscription};
use std::sync::Arc;
use std::thread::JoinHandle;

/// One joint's topics, and where its commands go.
#[derive(Clone)]
pub struct Joint {
    /// Its number in topic names.
    pub number: u16,
    /// Lets commands through.
    pub gate: Arc<CommandGate>,
}

/// A node that can be heard but does not listen yet.
pub struct RosNode {
    context: Context,
    node: Node,
}

/// The thread that listens.
pub struct Listener {
    stop: oneshot::Sender<()>,
    thread: JoinHandle<()>,
}

/// States to publish: reliable, which both kinds of subscribers can read.
///
/// A reliable subscriber that has died keeps its place until its lease ends: 20 s with Fast DDS, 10
/// s with Cyclone DDS. What it has not acknowledged is kept for it, and once that is `depth`
/// messages nothing is sent to anybody. So there is room for longer than that.
const STATE_QOS: QosProfile = QosProfile {
    reliability: Reliability::Reliable { when_full: WhenFull::Fail },
    durability: Durability::Volatile,
    history: History::KeepLast { depth: 30_000 },
    ..QosProfile::publisher_default()
};

/// Commands to listen to: best effort, which both kinds of publishers can serve. A lost command is
/// replaced by the next.
const COMMAND_QOS: QosProfile =
    QosProfile { history: History::KeepLast { depth: 16 }, ..QosProfile::subscription_default() };

/// As ROS's own diagnostics.
const DIAGNOSTICS_QOS: QosProfile = QosProfile {
    reliability: Reliability::Reliable { when_full: WhenFull::Fail },
    history: History::KeepLast { depth: 100 },
    ..QosProfile::publisher_default()
};

/// As other nodes offer /rosout: who comes later hears what was said before.
const ROSOUT_QOS: QosProfile = QosProfile {
    reliability: Reliability::Reliable { when_full: WhenFull::Fail },
    durability: Durability::TransientLocal,
    history: History::KeepLast { depth: 1_000 },
    ..QosProfile::publisher_default()
};

/// Reliable, which both kinds of subscribers can read; some seconds of readings.
const SENSOR_QOS: QosProfile = QosProfile {
    reliability: Reliability::Reliable { when_full: WhenFull::Fail },
    history: History::KeepLast { depth: 1_000 },
    ..QosProfile::publisher_default()
};

impl RosNode {
    /// Joins the DDS domain. `live` follows the parameters.
    pub fn new(settings: &Settings, live: &Arc<Live>) -> Result<Self, Failure> {
        let options = ContextOptions::new().domain_id(settings.domain_id);
        let context = Context::with_options(options).map_err(|error| {
            Failure::running(format!("cannot join DDS domain {}: {error}", settings.domain_id))
        })?;
        let name = settings.names.node_name().map_err(Failure::input)?;
        let node = context
            .new_node(name, parameters::declare(settings, live))
            .map_err(|error| Failure::running(format!("cannot make the node: {error}")))?;
        Ok(Self { context, node })
    }

    /// `/diagnostics`
    pub fn diagnostics(&mut self, settings: &Settings) -> Result<Publisher<DiagnosticArray>, Failure> {
        let type_name = MessageTypeName::new("diagnostic_msgs", "DiagnosticArray");
        self.publisher(settings, "/diagnostics", type_name, &DIAGNOSTICS_QOS)
    }

    /// `/rosout`
    pub fn rosout(&mut self) -> Result<Publisher<Log>, Failure> {
        let dds = |error| Failure::running(format!("/rosout: {error}"));
        let name = Name::parse("/rosout").map_err(Failure::input)?;
        let type_name = MessageTypeName::new("rcl_interfaces", "Log");
        let topic = self.node.create_topic(&name, type_name, &ROSOUT_QOS).map_err(dds)?;
        self.node.create_publisher(&topic, None).map_err(dds)
    }

    /// Where a joint's states go: a topic for each part that the type of message is about.
    pub fn states<M: PressureMessage>(
        &mut self,
        settings: &Settings,
        joint: &ChannelNames,
        bus: usize,
    ) -> Result<Vec<StateTopic<M>>, Failure> {
        let topic = |&part: &Part| {
            let topic = part.topic(joint.joint(), "pressure_state");
            let publisher = self.publisher(settings, &topic, type_name(&settings.message), &STATE_QOS)?;
            Ok(StateTopic { part, publisher, message: M::empty_state(joint, part, bus) })
        };
        M::PARTS.iter().map(topic).collect()
    }

    /// `~/joint_N/supply_pressure` and `~/joint_N/imu`.
    pub fn sensors(&mut self, settings: &Settings, joint: u16) -> Result<SensorTopics, Failure> {
        let topic = |name: &str| format!("~/joint_{joint}/{name}");
        let (pressure, imu) = (named(FluidPressure::ROS_TYPE), named(Imu::ROS_TYPE));
        let supply = self.publisher(settings, &topic("supply_pressure"), pressure, &SENSOR_QOS)?;
        let imu = self.publisher(settings, &topic("imu"), imu, &SENSOR_QOS)?;
        Ok(SensorTopics::new(joint, supply, imu))
    }

    fn publisher<M: serde::Serialize>(
        &mut self,
        settings: &Settings,
        topic: &str,
        type_name: MessageTypeName,
        qos: &QosProfile,
    ) -> Result<Publisher<M>, Failure> {
        let name = settings.names.topic(topic).map_err(Failure::input)?;
        let dds = |error| Failure::running(format!("{topic}: {error}"));
        let topic = self.node.create_topic(&name, type_name, qos).map_err(dds)?;
        self.node.create_publisher(&topic, None).map_err(dds)
    }

    /// Listens to commands and to what is asked about parameters, on a thread of its own.
    pub fn listen<M: PressureMessage>(
        mut self,
        settings: &Settings,
        joints: Vec<Joint>,
        live: Arc<Live>,
        target: Target,
    ) -> Result<Listener, Failure> {
        let services = Services::new(&mut self.node, settings, target)?;
        let parameters = ParameterServices::new(&mut self.node, settings)?;
        let mut subscriptions = Vec::new();
        let parts = joints.iter().flat_map(|joint| M::PARTS.iter().map(move |&part| (joint.clone(), part)));
        for (joint, part) in parts {
            let topic = part.topic(joint.number, "pressure_command");
            let name = settings.names.topic(&topic).map_err(Failure::input)?;
            let dds = |error| Failure::running(format!("{topic}: {error}"));
            let topic =
                self.node.create_topic(&name, type_name(&settings.message), &COMMAND_QOS).map_err(dds)?;
            let subscription = self.node.create_subscription::<M>(&topic, None).map_err(dds)?;
            subscriptions.push((joint, part, subscription));
        }
        let spinner =
            self.node.spinner().map_err(|error| Failure::running(format!("cannot listen: {error}")))?;
        let (stop, stopped) = oneshot::channel();
        let thread = std::thread::Builder::new().name("pneudrive-ros".into()).spawn(move || {
            block_on(async {
                let commands = std::pin::pin!(follow(&subscriptions, &live));
                let spinning = std::pin::pin!(spinner.spin());
                // The spinner ends only with the node, the streams never: whichever ends first, it
                // is over.
                let answering = std::pin::pin!(join(services.answer(), parameters.answer(&self.node)));
                let work = select(select(commands, answering), spinning);
                if let Either::Right(_) = select(stopped, work).await {
                    log::error!("DDS has ended");
                }
            });
            // In this order: others are told of each end, or they list a dead node for ever.
            drop((subscriptions, services, parameters));
            drop(self.node);
            drop(self.context);
        });
        let thread = thread.map_err(|error| Failure::running(format!("no thread to listen: {error}")))?;
        Ok(Listener { stop, thread })
    }
}

impl Listener {
    /// Leaves the DDS domain.
    pub fn stop(self) {
        let _ = self.stop.send(());
        if self.thread.join().is_err() {
            log::error!("the listening thread panicked; see above");
        }
    }
}

/// Passes every command on to its joint's gate.
async fn follow<M: PressureMessage>(subscriptions: &[(Joint, Part, Subscription<M>)], live: &Live) {
    let mut commands: SelectAll<_> = subscriptions
        .iter()
        .map(|(joint, part, subscription)| {
            subscription.async_stream().map(move |message| (joint, *part, message)).boxed_local()
        })
        .collect();
    while let Some((joint, part, message)) = commands.next().await {
        let message = match message {
            Ok((message, _)) => message,
            Err(error) => {
                log::warn!("joint_{}: a command that is no message: {error:?}", joint.number);
                continue;
            }
        };
        let offered = joint.gate.offer(&message.command(part), unix_now_ns(), live.max_command_age_ns());
        if let Err(refusal) = offered
            && *joint.gate.counters().refused_for(&refusal) == 1
        {
            log::warn!(
                "joint_{}: command refused: {refusal}; further ones of this kind are counted in /diagnostics",
                joint.number
            );
        }
    }
}

fn type_name(message: &MessageType) -> MessageTypeName {
    match message {
        MessageType::JointState => named(JointState::ROS_TYPE),
        MessageType::FluidPressure => named(FluidPressure::ROS_TYPE),
        MessageType::Pressures { package, name } => MessageTypeName::new(package, name),
    }
}

/// A type by its whole name, such as `sensor_msgs/msg/Imu`.
fn named(ros_type: &str) -> MessageTypeName {
    let (package, name) = ros_type.split_once("/msg/").unwrap_or_default();
    MessageTypeName::new(package, name)
}
