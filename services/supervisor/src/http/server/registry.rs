//! Registry of open connections. When a limit is reached, it chooses a connection to close for the new one.
//!
//! A connection waits while it has no complete request under way. When there is no room, the one that has waited
//! longest is closed: a client that sends its request at once is served even if another one opens connections without
//! end.

use std::collections::{BTreeMap, HashMap};
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::oneshot;

use crate::http::client_address::counted;
use crate::metrics::ConnectionMetrics;

/// How many connections may be open at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Connections from all addresses together.
    pub connections_max: u32,
    /// From one address; an IPv6 network of 64 bits counts as one, because one host can have all of it.
    pub connections_per_address_max: u32,
}

impl Default for Limits {
    fn default() -> Self {
        Self { connections_max: 2048, connections_per_address_max: 512 }
    }
}

/// Why a connection was closed or refused by a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Limit {
    /// Of all connections.
    Total,
    /// Of those from one address.
    Address,
}

/// The connections of one listener.
#[derive(Debug, Clone)]
pub(super) struct Registry(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    limits: Limits,
    metrics: ConnectionMetrics,
    open: Mutex<Open>,
}

#[derive(Debug, Default)]
struct Open {
    /// The next number; numbers order connections, and the moments since which they wait.
    next: u64,
    connections: HashMap<u64, Connection>,
    /// Numbers of connections by the order in which they began to wait.
    waiting: BTreeMap<u64, u64>,
    addresses: HashMap<IpAddr, Address>,
}

#[derive(Debug)]
struct Connection {
    address: IpAddr,
    /// Its place among the waiting connections; `None` while a request is under way.
    waits: Option<u64>,
    /// Dropped to close the connection.
    _close: oneshot::Sender<()>,
}

#[derive(Debug, Default)]
struct Address {
    open: u32,
    waiting: BTreeMap<u64, u64>,
}

/// Entry of an open connection; dropping it frees the place.
#[derive(Debug)]
pub(super) struct Slot {
    registry: Registry,
    number: u64,
}

/// An admitted connection.
#[derive(Debug)]
pub(super) struct Admitted {
    /// The connection's entry in the registry.
    pub(super) place: Slot,
    /// Resolves when the connection must close to make room for another.
    pub(super) displaced: oneshot::Receiver<()>,
    /// The limit for which another connection was closed.
    pub(super) reached: Option<Limit>,
}

impl Registry {
    pub(super) fn new(limits: Limits, metrics: ConnectionMetrics) -> Self {
        Self(Arc::new(Shared { limits, metrics, open: Mutex::default() }))
    }

    /// Admits a connection, if necessary by closing a waiting one. The error is the limit reached by connections that
    /// all have requests under way.
    pub(super) fn admit(&self, peer: IpAddr) -> Result<Admitted, Limit> {
        let Shared { limits, metrics, .. } = &*self.0;
        let address = counted(peer);
        let mut open = self.open();
        let mut reached = None;
        let of_address = open.addresses.get(&address).map_or(0, |address| address.open);
        if of_address >= limits.connections_per_address_max {
            let oldest = open.addresses.get(&address).and_then(|address| address.waiting.values().next().copied());
            open.remove(oldest.ok_or(Limit::Address)?);
            metrics.displaced();
            reached = Some(Limit::Address);
        }
        if open.connections.len() >= limits.connections_max as usize {
            open.displace().ok_or(Limit::Total)?;
            metrics.displaced();
            reached = Some(Limit::Total);
        }
        let (close, displaced) = oneshot::channel();
        let number = open.number();
        open.connections.insert(number, Connection { address, waits: None, _close: close });
        open.addresses.entry(address).or_default().open += 1;
        open.wait(number);
        metrics.open.set(open.connections.len() as i64);
        Ok(Admitted { place: Slot { registry: self.clone(), number }, displaced, reached })
    }

    /// Closes the connection that has waited longest, whatever the limits are; false if none waits.
    pub(super) fn displace(&self) -> bool {
        let mut open = self.open();
        let is_displaced = open.displace().is_some();
        if is_displaced {
            self.0.metrics.displaced();
            self.0.metrics.open.set(open.connections.len() as i64);
        }
        is_displaced
    }

    fn open(&self) -> MutexGuard<'_, Open> {
        self.0.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Slot {
    /// A complete request has arrived: the connection is not closed for another until it is answered.
    pub(super) fn serve(&self) {
        self.registry.open().serve(self.number);
    }

    /// The request is answered.
    pub(super) fn wait(&self) {
        self.registry.open().wait(self.number);
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        let mut open = self.registry.open();
        open.remove(self.number);
        self.registry.0.metrics.open.set(open.connections.len() as i64);
    }
}

impl Open {
    fn number(&mut self) -> u64 {
        self.next += 1;
        self.next
    }

    /// Puts a connection behind all others that wait.
    fn wait(&mut self, number: u64) {
        let order = self.number();
        // It may have been displaced.
        let Some(connection) = self.connections.get_mut(&number) else { return };
        if connection.waits.is_some() {
            return;
        }
        connection.waits = Some(order);
        self.waiting.insert(order, number);
        self.addresses.entry(connection.address).or_default().waiting.insert(order, number);
    }

    fn serve(&mut self, number: u64) {
        let Some(connection) = self.connections.get_mut(&number) else { return };
        let Some(order) = connection.waits.take() else { return };
        self.waiting.remove(&order);
        if let Some(address) = self.addresses.get_mut(&connection.address) {
            address.waiting.remove(&order);
        }
    }

    fn displace(&mut self) -> Option<()> {
        let oldest = self.waiting.values().next().copied()?;
        self.remove(oldest);
        Some(())
    }

    fn remove(&mut self, number: u64) {
        self.serve(number);
        let Some(connection) = self.connections.remove(&number) else { return };
        if let Some(address) = self.addresses.get_mut(&connection.address) {
            address.open -= 1;
            if address.open == 0 {
                self.addresses.remove(&connection.address);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Metrics;

    fn registry(connections_max: u32, connections_per_address_max: u32) -> (Registry, Metrics) {
        let metrics = Metrics::new(false).unwrap();
        let limits = Limits { connections_max, connections_per_address_max };
        (Registry::new(limits, metrics.http.connections("main")), metrics)
    }

    fn address(last: u8) -> IpAddr {
        IpAddr::from([10, 0, 0, last])
    }

    fn is_displaced(admitted: &mut Admitted) -> bool {
        admitted.displaced.try_recv() == Err(oneshot::error::TryRecvError::Closed)
    }

    #[test]
    fn the_connection_that_has_waited_longest_is_closed_for_a_new_one() {
        let (registry, _metrics) = registry(3, 3);
        let mut all: Vec<Admitted> = (0..3).map(|last| registry.admit(address(last)).unwrap()).collect();
        // The first has a request under way, the second had one and waits again.
        all[0].place.serve();
        all[1].place.serve();
        all[1].place.wait();
        all.push(registry.admit(address(9)).unwrap());
        assert_eq!(all.iter_mut().map(is_displaced).collect::<Vec<_>>(), [false, false, true, false]);
        all.push(registry.admit(address(9)).unwrap());
        assert_eq!(all.iter_mut().map(is_displaced).collect::<Vec<_>>(), [false, true, true, false, false]);
        assert_eq!(all[4].reached, Some(Limit::Total));
    }

    #[test]
    fn an_address_at_its_limit_loses_its_own_connections() {
        let (registry, _metrics) = registry(10, 2);
        let mut other = registry.admit(address(1)).unwrap();
        let mut first = registry.admit(address(2)).unwrap();
        let mut second = registry.admit(address(2)).unwrap();
        let mut third = registry.admit(address(2)).unwrap();
        assert_eq!(third.reached, Some(Limit::Address));
        let displaced = [&mut other, &mut first, &mut second, &mut third].map(is_displaced);
        assert_eq!(displaced, [false, true, false, false]);
    }

    #[test]
    fn a_connection_with_a_request_under_way_is_never_closed_for_another() {
        let (registry, metrics) = registry(2, 1);
        let first = registry.admit(address(1)).unwrap();
        first.place.serve();
        assert_eq!(registry.admit(address(1)).unwrap_err(), Limit::Address);
        let second = registry.admit(address(2)).unwrap();
        second.place.serve();
        assert_eq!(registry.admit(address(3)).unwrap_err(), Limit::Total);
        assert!(!registry.displace());
        drop(first);
        assert!(registry.admit(address(3)).is_ok());
        assert_eq!(metrics.http.connections("main").open.get(), 1, "the last was dropped again");
    }

    #[test]
    fn property_after_any_sequence_everything_is_counted_once() {
        let (registry, _metrics) = registry(6, 4);
        let mut open: Vec<Admitted> = Vec::new();
        let mut random = 12_345_u32;
        for _ in 0..20_000 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let (choice, which) = ((random >> 24) % 4, (random >> 16) as usize);
            match choice {
                0 | 1 => open.extend(registry.admit(address((which % 3) as u8)).ok()),
                2 if !open.is_empty() => drop(open.swap_remove(which % open.len())),
                _ if !open.is_empty() => {
                    let place = &open[which % open.len()].place;
                    if random & 1 == 0 { place.serve() } else { place.wait() }
                }
                _ => {}
            }
            open.retain_mut(|one| !is_displaced(one));
            let parts = registry.open();
            assert_eq!(parts.connections.len(), open.len());
            assert!(open.len() <= 6 && parts.addresses.values().all(|address| (1..=4).contains(&address.open)));
            assert_eq!(parts.addresses.values().map(|address| address.open as usize).sum::<usize>(), open.len());
            let waiting = parts.connections.values().filter(|connection| connection.waits.is_some()).count();
            assert_eq!(parts.waiting.len(), waiting);
            assert_eq!(parts.addresses.values().map(|address| address.waiting.len()).sum::<usize>(), waiting);
        }
    }
}
