//! Takes connections, all on one thread of its own.

use crate::access::Names;
use crate::connections::Connections;
use crate::deadman::Deadman;
use crate::hub::Hub;
use crate::run::{Commanding, Run};
use crate::{PageOptions, api, sampler};
use axum::Router;
use axum::body::Body;
use hyper::server::conn::http1;
use hyper::service::Service;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use rustix::net::sockopt::set_socket_send_buffer_size;
use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tokio::net::TcpStream;
use tokio_io_timeout::TimeoutStream;

/// A client has this long for the head of its request, however it is cut up, and again for its
/// body.
pub(crate) const REQUEST_WITHIN: Duration = Duration::from_secs(5);
/// A client that takes nothing for so long is gone.
const WRITE_WITHIN: Duration = Duration::from_secs(5);
/// Longest head, bytes. hyper takes nothing smaller.
const MOST_HEAD: usize = 8 * 1024;
const MOST_HEADERS: usize = 64;
/// What the kernel may keep of what a client has not read, bytes: a few seconds of pictures. More
/// would show a slow client the past.
const SEND_BUFFER: usize = 32 * 1024;
/// How long clients are given to hear the end.
const GOODBYE: Duration = Duration::from_millis(500);
/// How often the operator's page is missed.
const DEADMAN_EVERY: Duration = Duration::from_millis(50);

/// An address that is ours, with nobody served yet.
#[derive(Debug)]
pub struct Listener {
    socket: TcpListener,
    address: SocketAddr,
}

/// A page that is being served. Ends when dropped.
pub struct Server {
    address: SocketAddr,
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
}

/// What all requests have in common.
pub(crate) struct Shared {
    pub(crate) hub: Hub,
    pub(crate) options: PageOptions,
    pub(crate) names: Names,
    pub(crate) run: Arc<dyn Run>,
    pub(crate) connections: Arc<Connections>,
    deadman: Mutex<Deadman>,
    started: Instant,
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

    /// Starts serving a run.
    ///
    /// # Errors
    /// The system has no threads to give, or nothing to wait for sockets with.
    pub fn serve(self, options: PageOptions, run: Arc<dyn Run>) -> io::Result<Server> {
        let names = Names::new(&options.names);
        let deadman = Deadman::new(options.control.as_ref().and_then(|control| control.deadman));
        let shared = Arc::new(Shared {
            hub: Hub::default(),
            options,
            names,
            run,
            connections: Arc::default(),
            deadman: Mutex::new(deadman),
            started: Instant::now(),
        });
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_io()
            .enable_time()
            // Recordings are started and stopped there.
            .max_blocking_threads(1)
            .thread_stack_size(STACK)
            .thread_name("pneudrive-disk")
            .build()?;
        let mut server = Server { address: self.address, shared: Arc::clone(&shared), threads: Vec::new() };
        let theirs = Arc::clone(&shared);
        server.threads.push(thread("pneudrive-look").spawn(move || sampler::run(&theirs))?);
        let socket = self.socket;
        server.threads.push(thread("pneudrive-web").spawn(move || {
            if let Err(error) = runtime.block_on(serve(socket, &shared)) {
                log::error!("the page is not served: {error}");
            }
            runtime.shutdown_timeout(GOODBYE);
        })?);
        Ok(server)
    }
}

impl Server {
    /// The page's address, for people: an address that can be typed in where it listens on all of
    /// them.
    pub fn url(&self) -> String {
        let mut address = self.address;
        if address.ip().is_unspecified() {
            address.set_ip(IpAddr::V4(Ipv4Addr::LOCALHOST));
        }
        format!("http://{address}/")
    }

    /// Connections that had to go so far, because there was no room for another.
    pub fn dropped(&self) -> u64 {
        self.shared.connections.dropped()
    }

    /// Tells all clients that the run has ended, with a reason if it was not meant to, and ends.
    pub fn end(mut self, reason: Option<&str>) {
        self.finish(reason);
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
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.finish(None);
    }
}

impl Shared {
    /// Whoever watches the operator's page, and the time for it.
    pub(crate) fn deadman(&self) -> (MutexGuard<'_, Deadman>, Duration) {
        (self.deadman.lock().unwrap_or_else(PoisonError::into_inner), self.started.elapsed())
    }

    /// Vents. `who` ends the line about it: one line for what has changed, however often it is
    /// asked.
    pub(crate) fn vent(&self, who: &str) {
        if self.run.vent() {
            self.run.notice(format!("all boards vented {who}"));
        }
    }

    /// Vents if the operator's page is gone.
    fn watch_operator(&self) {
        let vented = self.run.commanding() == Commanding::Vented;
        let (mut deadman, now) = self.deadman();
        let gone = deadman.check(now, vented);
        drop(deadman);
        if let Some(silent) = gone {
            self.vent(&deadman_line(silent));
            self.hub.line(&format!("all boards vented {}", deadman_line(silent)));
        }
    }
}

fn deadman_line(silent: Duration) -> String {
    format!("because the operator's page has been gone for {:.1} s (deadman mode)", silent.as_secs_f64())
}

/// A process that is locked in memory pays for every byte of a stack.
const STACK: usize = 256 * 1024;

fn thread(name: &str) -> std::thread::Builder {
    std::thread::Builder::new().name(name.into()).stack_size(STACK)
}

/// Until the run has ended.
async fn serve(socket: TcpListener, shared: &Arc<Shared>) -> io::Result<()> {
    let socket = tokio::net::TcpListener::from_std(socket)?;
    let router = api::router(shared);
    let mut deadman = tokio::time::interval(DEADMAN_EVERY);
    deadman.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
    let mut ended = std::pin::pin!(shared.hub.ended());
    loop {
        // In this order, so that no number of new clients comes before the deadman.
        tokio::select! {
            biased;
            () = &mut ended => break,
            _ = deadman.tick() => shared.watch_operator(),
            accepted = socket.accept() => match accepted {
                Ok((stream, peer)) => {
                    let (place, gone) = shared.connections.admit(peer.ip());
                    let connection = connection(stream, peer.ip(), place, router.clone());
                    tokio::spawn(async move {
                        tokio::select! {
                            () = connection => {}
                            _ = gone => {}
                        }
                    });
                    // What it has sent is read before the next client can take its place.
                    tokio::task::yield_now().await;
                }
                Err(error) => {
                    // Out of files, or a client that has changed its mind.
                    if error.kind() != io::ErrorKind::ConnectionAborted {
                        shared.connections.make_room();
                    }
                    tokio::time::sleep(Duration::from_millis(10)).await;
                }
            },
        }
    }
    let goodbye = Instant::now() + GOODBYE;
    while !shared.connections.is_empty() && Instant::now() < goodbye {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    Ok(())
}

/// One request, and its answer.
async fn connection(stream: TcpStream, peer: IpAddr, place: crate::connections::Place, router: Router) {
    // A system that does not want to is no reason to show nothing.
    let _ = stream.set_nodelay(true);
    let _ = set_socket_send_buffer_size(&stream, SEND_BUFFER);
    let mut stream = TimeoutStream::new(stream);
    stream.set_write_timeout(Some(WRITE_WITHIN));
    let client = api::Client { address: peer, place: Arc::new(place) };
    let router = TowerToHyperService::new(router);
    let service = hyper::service::service_fn(move |mut request: hyper::Request<hyper::body::Incoming>| {
        request.extensions_mut().insert(client.clone());
        router.call(request.map(Body::new))
    });
    let served = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(REQUEST_WITHIN)
        .max_buf_size(MOST_HEAD)
        .max_headers(MOST_HEADERS)
        .keep_alive(false)
        // Scripts may close their side when they have asked.
        .half_close(true)
        .serve_connection(TokioIo::new(Box::pin(stream)), service)
        .await;
    // A client that goes, or is no browser at all, is no error of ours.
    drop(served);
}
