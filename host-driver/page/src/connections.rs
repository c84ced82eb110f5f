//! How many clients there are, and who goes when there is no more room.
//!
//! A new connection always gets a place, so that nobody can keep a vent out: where all are taken,
//! the client with the most connections loses its oldest. A request is read within a moment of its
//! arrival; what is old there is a half-sent request, or an answer that nobody takes. Streams are
//! counted apart, and a client cannot take all of them.

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::oneshot;

/// Connections at a time that are no streams.
const MOST_REQUESTS: usize = 128;
/// Streams at a time.
const MOST_STREAMS: usize = 32;
/// Streams at a time to one address.
const MOST_STREAMS_OF_ONE: usize = 16;

/// The connections that there are.
#[derive(Debug, Default)]
pub(crate) struct Connections {
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// The next connection's number. Older ones have smaller numbers.
    next: u64,
    requests: BTreeMap<u64, Client>,
    streams: BTreeMap<u64, Client>,
    dropped: u64,
}

#[derive(Debug)]
struct Client {
    address: IpAddr,
    /// Dropped when the connection is to end.
    _keep: oneshot::Sender<()>,
}

/// A connection's place, until dropped.
#[derive(Debug)]
pub(crate) struct Place {
    connections: Arc<Connections>,
    number: u64,
}

impl Connections {
    /// A place for a new connection, and what resolves when it must go.
    pub(crate) fn admit(self: &Arc<Self>, address: IpAddr) -> (Place, oneshot::Receiver<()>) {
        let (keep, gone) = oneshot::channel();
        let mut state = self.state();
        if state.requests.len() >= MOST_REQUESTS {
            state.drop_one();
        }
        let number = state.next;
        state.next += 1;
        state.requests.insert(number, Client { address: network(address), _keep: keep });
        (Place { connections: Arc::clone(self), number }, gone)
    }

    /// Whether nobody is left.
    pub(crate) fn is_empty(&self) -> bool {
        let state = self.state();
        state.requests.is_empty() && state.streams.is_empty()
    }

    /// Drops the oldest connection of the client with the most, as where no place is left. For a
    /// system that has no more files.
    pub(crate) fn make_room(&self) {
        self.state().drop_one();
    }

    /// Connections that had to go so far.
    pub(crate) fn dropped(&self) -> u64 {
        self.state().dropped
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn drop_one(&mut self) {
        let mut counts = BTreeMap::new();
        for client in self.requests.values() {
            *counts.entry(client.address).or_insert(0usize) += 1;
        }
        let most = counts.values().max().copied();
        let oldest = self.requests.iter().find(|(_, client)| counts.get(&client.address).copied() == most);
        if let Some(number) = oldest.map(|(&number, _)| number) {
            self.requests.remove(&number);
            self.dropped += 1;
        }
    }
}

impl Place {
    /// Makes a stream of it. `false` if there are as many as there may be.
    pub(crate) fn become_stream(&self) -> bool {
        let mut state = self.connections.state();
        let Some(client) = state.requests.get(&self.number) else {
            return false;
        };
        let of_one = state.streams.values().filter(|other| other.address == client.address).count();
        if of_one >= MOST_STREAMS_OF_ONE || state.streams.len() >= MOST_STREAMS {
            return false;
        }
        if let Some(client) = state.requests.remove(&self.number) {
            state.streams.insert(self.number, client);
        }
        true
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut state = self.connections.state();
        state.requests.remove(&self.number);
        state.streams.remove(&self.number);
    }
}

/// What counts as one client. Who has an IPv6 address has 2^64 of them (RFC 6177).
fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(v6) => {
            let [a, b, c, d, ..] = v6.segments();
            Ipv6Addr::new(a, b, c, d, 0, 0, 0, 0).into()
        }
        v4 => v4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(last: u8) -> IpAddr {
        [10, 0, 0, last].into()
    }

    fn is_gone(gone: &mut oneshot::Receiver<()>) -> bool {
        gone.try_recv() == Err(oneshot::error::TryRecvError::Closed)
    }

    #[test]
    fn a_new_connection_takes_the_place_of_the_oldest_of_the_busiest() {
        let connections = Arc::new(Connections::default());
        let mut patient = connections.admit(address(1));
        let mut crowd: Vec<_> = (1..MOST_REQUESTS).map(|_| connections.admit(address(2))).collect();
        assert!(!crowd.iter_mut().any(|(_, gone)| is_gone(gone)));
        let mut newcomer = connections.admit(address(3));
        let gone: Vec<_> = crowd.iter_mut().map(|(_, gone)| is_gone(gone)).collect();
        assert!(gone[0] && !gone[1..].contains(&true), "{gone:?}");
        for _ in 0..1_000 {
            crowd.push(connections.admit(address(2)));
        }
        assert!(!is_gone(&mut patient.1) && !is_gone(&mut newcomer.1), "the crowd drops its own");
        assert_eq!(connections.dropped(), 1_001);
        assert!(!is_gone(&mut crowd.last_mut().unwrap().1), "the newest has a place");
        drop((patient, newcomer, crowd));
        assert!(connections.is_empty());
    }

    #[test]
    fn a_client_cannot_take_all_streams() {
        let connections = Arc::new(Connections::default());
        let stream = |last| {
            let admitted = connections.admit(address(last));
            admitted.0.become_stream().then_some(admitted)
        };
        let mut first: Vec<_> = (0..MOST_STREAMS_OF_ONE).map(|_| stream(1).unwrap()).collect();
        assert!(stream(1).is_none());
        let other = stream(2);
        assert!(other.is_some(), "others can");
        assert!(!is_gone(&mut first[0].1), "a stream is not dropped for it");
        drop(first.pop());
        let _again = stream(1).unwrap();
        let _rest: Vec<_> = (0..15).map(|_| stream(3).unwrap()).collect();
        assert!(stream(4).is_none(), "32 are all");
    }

    #[test]
    fn a_network_of_ipv6_is_one_client() {
        let one = |text: &str| network(text.parse().unwrap());
        assert_eq!(one("2001:db8:1:2::1"), one("2001:db8:1:2:ffff::9"));
        assert_ne!(one("2001:db8:1:2::1"), one("2001:db8:1:3::1"));
        assert_eq!(one("::ffff:10.0.0.1"), address(1));
    }
}
