//! `~/vent` and `~/release`, of type `std_srvs/srv/Trigger`.

use crate::args::Settings;
use crate::failure::Failure;
use crate::gate::CommandGate;
use futures::StreamExt;
use futures::future::join;
use pneudrive_host::poller::VentLatch;
use ros2_client::qos::{History, QosProfile};
use ros2_client::service::Server;
use ros2_client::{Message, Node, ServiceMapping, ServiceTypeName};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// An empty request: DDS has no empty structures, so ROS puts a byte into them.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Request {
    structure_needs_at_least_one_member: u8,
}

/// How it went.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Response {
    success: bool,
    message: String,
}

impl Message for Request {}
impl Message for Response {}

/// What is vented and released: all buses of the node at once.
#[derive(Debug, Clone)]
pub struct Target {
    /// One for each bus.
    pub latches: Vec<VentLatch>,
    /// One for each joint.
    pub gates: Vec<Arc<CommandGate>>,
}

impl Target {
    /// 0 kPa to all boards, until released.
    pub fn vent(&self) {
        self.latches.iter().for_each(VentLatch::vent);
    }

    /// Follows commands again. What was commanded before does not return: the next command moves
    /// something.
    pub fn release(&self) {
        self.gates.iter().for_each(|gate| gate.clear());
        self.latches.iter().for_each(VentLatch::release);
    }
}

/// The two services.
pub struct Services {
    vent: Server<Request, Response>,
    release: Server<Request, Response>,
    target: Target,
}

impl Services {
    /// Offers them.
    pub fn new(node: &mut Node, settings: &Settings, target: Target) -> Result<Self, Failure> {
        let mut server = |service: &str| offer(node, settings, service, ("std_srvs", "Trigger"));
        Ok(Self { vent: server("~/vent")?, release: server("~/release")?, target })
    }

    /// Answers until the node ends.
    pub async fn answer(&self) {
        let done = |message: &str| Response { success: true, message: message.to_owned() };
        let vent = serve(&self.vent, |_| {
            self.target.vent();
            done("all boards are vented until ~/release is called")
        });
        let release = serve(&self.release, |_| {
            self.target.release();
            done("commands from now on are followed; set points are 0 kPa until then")
        });
        join(vent, release).await;
    }
}

/// Answers the requests of one service until the node ends.
pub async fn serve<Q: Message + Clone + 'static, R: Message + 'static>(
    server: &Server<Q, R>,
    answer: impl Fn(Q) -> R,
) {
    let mut requests = server.receive_request_stream();
    while let Some(request) = requests.next().await {
        let Ok((id, request)) = request else {
            log::warn!("a request that cannot be read");
            continue;
        };
        if let Err(error) = server.async_send_response(id, answer(request)).await {
            log::warn!("an answer that cannot be sent: {error:?}");
        }
    }
}

/// Offers a service of the node: `~/vent` of type `std_srvs/Trigger`, for example.
pub fn offer<Q: Message + Clone + 'static, R: Message + Clone + 'static>(
    node: &mut Node,
    settings: &Settings,
    service: &str,
    (package, kind): (&str, &str),
) -> Result<Server<Q, R>, Failure> {
    let qos = QosProfile::publisher_default().history(History::KeepLast { depth: 10 });
    let name = settings.names.topic(service).map_err(Failure::input)?;
    let kind = ServiceTypeName::new(package, kind);
    node.create_server(ServiceMapping::Enhanced, &name, &kind, qos.clone(), qos)
        .map_err(|error| Failure::running(format!("{service}: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channel_names::ChannelNames;
    use crate::gate::Joint;
    use crate::pressure::{Part, PressureMessage};
    use pneudrive_host::poller::{Limits, SetPoints, VENTED};
    use pneudrive_protocol::SensorScale;
    use pneudrive_record::messages::JointState;

    #[test]
    fn a_release_follows_new_commands_only() {
        let points = SetPoints::new(1);
        let (limits, scales) = (Limits::default(), [SensorScale::ORIGINAL; 4]);
        let gate = CommandGate::new(
            points.clone(),
            Joint { names: ChannelNames::default(), board: 0, index: 0, limits, scales },
        );
        let target = Target { latches: vec![VentLatch::default(); 2], gates: vec![Arc::new(gate)] };
        let command = JointState { effort: vec![100.0; 4], ..JointState::default() };
        let offer = || target.gates[0].offer(&command.command(Part::Joint), 1, 0);
        offer().unwrap();
        target.vent();
        assert!(target.latches.iter().all(VentLatch::is_vented));
        target.release();
        assert!(!target.latches.iter().any(VentLatch::is_vented));
        assert_eq!(points.get(0), Some(VENTED));
        offer().unwrap();
        assert_ne!(points.get(0), Some(VENTED));
    }
}
