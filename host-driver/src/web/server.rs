//! Accepts clients, a thread for each.

use super::WebOptions;
use super::access::Names;
use super::api::{Reply, reply};
use super::connections::Connections;
use super::http::{BadRequest, Request, Response};
use super::hub::Hub;
use super::{sampler, stream};
use crate::line::Clock;
use crate::poller::Monitor;
use crate::record::{RecordError, RecordingSummary};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

/// Clients that look. More are told to come back later.
const MOST_STREAMS: usize = 16;
/// Connections at a time, so that there are always some left for actions.
const MOST_CONNECTIONS: usize = 48;
/// How long clients are given to hear the end.
const GOODBYE: Duration = Duration::from_millis(500);

/// An address that is ours, with nobody served yet.
#[derive(Debug)]
pub struct Listener {
    socket: TcpListener,
    address: SocketAddr,
}

/// A page that is being served. Ends when dropped.
pub struct Server {
    address: SocketAddr,
    connections: Connections,
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
}

/// What every connection's thread has.
struct Shared {
    hub: Hub,
    options: WebOptions,
    names: Names,
    streams: Connections,
}

impl Listener {
    /// Takes the address; port 0 is any free one.
    ///
    /// # Errors
    /// What the system says: the port is taken, the address is not ours.
    pub fn bind(address: SocketAddr) -> io::Result<Self> {
        let socket = TcpListener::bind(address)?;
        let address = socket.local_addr()?;
        socket.set_nonblocking(true)?;
        Ok(Self { socket, address })
    }

    /// The address with its actual port.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Starts serving the run that `monitor` sees. `clock` is the clock of its rows.
    ///
    /// # Errors
    /// The system has no threads to give.
    pub fn serve(self, options: WebOptions, monitor: Monitor, clock: Clock) -> io::Result<Server> {
        let names = Names::new(&options.names);
        let streams = Connections::new(MOST_STREAMS);
        let shared = Arc::new(Shared { hub: Hub::default(), options, names, streams });
        let connections = Connections::new(MOST_CONNECTIONS);
        let mut server = Server {
            address: self.address,
            connections: connections.clone(),
            shared: Arc::clone(&shared),
            threads: Vec::new(),
        };
        let theirs = Arc::clone(&shared);
        server.threads.push(
            thread("pneudrive-look")
                .spawn(move || sampler::run(&theirs.hub, &theirs.options, &monitor, clock))?,
        );
        let socket = self.socket;
        server.threads.push(thread("pneudrive-web").spawn(move || accept(&socket, &shared, &connections))?);
        Ok(server)
    }
}

impl Server {
    /// The page's address, for people: an address that can be typed in where it listens on all of them.
    pub fn url(&self) -> String {
        let mut address = self.address;
        if address.ip().is_unspecified() {
            address.set_ip(IpAddr::V4(Ipv4Addr::LOCALHOST));
        }
        format!("http://{address}/")
    }

    /// Tells all clients that the run has ended, with a reason if it was not meant to, and ends. To be called when the poller has
    /// ended. Returns what became of a recording that was still in progress.
    pub fn end(mut self, reason: Option<&str>) -> Option<Result<RecordingSummary, RecordError>> {
        self.finish(reason);
        self.shared.options.recording.as_ref().and_then(|recording| recording.switch.finish())
    }

    fn finish(&mut self, reason: Option<&str>) {
        if self.threads.is_empty() {
            return;
        }
        self.shared.hub.end(serde_json::json!({ "reason": reason }).to_string());
        for thread in self.threads.drain(..) {
            // A thread that panicked has said so.
            let _ = thread.join();
        }
        self.connections.wait_until_none(GOODBYE);
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.finish(None);
    }
}

fn thread(name: &str) -> std::thread::Builder {
    // A process that is locked in memory pays for every byte of a stack.
    const STACK: usize = 256 * 1024;
    std::thread::Builder::new().name(name.into()).stack_size(STACK)
}

/// Until the run has ended.
fn accept(socket: &TcpListener, shared: &Arc<Shared>, connections: &Connections) {
    while !shared.hub.has_ended() {
        let mut files = [PollFd::new(socket, PollFlags::IN)];
        let patience = Timespec { tv_sec: 0, tv_nsec: 100_000_000 };
        if !matches!(poll(&mut files, Some(&patience)), Ok(ready) if ready > 0) {
            continue;
        }
        let Ok((mut stream, peer)) = socket.accept() else {
            // Out of files, or a client that has changed its mind.
            std::thread::sleep(Duration::from_millis(10));
            continue;
        };
        let Some(place) = connections.place() else {
            let _ = busy().write(&mut stream);
            continue;
        };
        let theirs = Arc::clone(shared);
        let spawned = thread("pneudrive-client").spawn(move || {
            serve(stream, peer, &theirs);
            drop(place);
        });
        if let Err(error) = spawned {
            log::warn!("no thread for a web client: {error}");
        }
    }
}

fn serve(mut stream: TcpStream, peer: SocketAddr, shared: &Shared) {
    if stream.set_nonblocking(false).is_err() {
        return;
    }
    let response = match Request::read(&mut stream) {
        Err(BadRequest::Gone) => return,
        Err(BadRequest::Status(status, message)) => Response::error(status, message),
        Ok(request) => {
            match reply(&request, &shared.hub, &shared.options, &shared.names, &peer.ip().to_string()) {
                Reply::Whole(response) => response,
                Reply::Pictures => match shared.streams.place() {
                    Some(_place) => {
                        // A client that goes is no error.
                        let _ = stream::serve(&mut stream, &shared.hub, &shared.options);
                        return;
                    }
                    None => busy(),
                },
            }
        }
    };
    let _ = response.write(&mut stream);
}

fn busy() -> Response {
    Response::error(503, "too many clients; close other pages")
}
