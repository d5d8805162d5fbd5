//! A network of namespaces on a bridge, each of which can be cut off. It needs root.

use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};
use std::process::{Command, Stdio};

use crate::process::Launch;

/// Attempts to find a free name and subnet.
const ATTEMPTS: usize = 5;

/// Where a server runs: an address, and the namespace that has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ServerAddress {
    /// Address to listen at.
    pub host: String,
    /// Namespace; `None` for this machine's own network.
    pub namespace: Option<String>,
}

impl ServerAddress {
    /// 127.0.0.1 of this machine.
    #[must_use]
    pub fn here() -> Self {
        Self { host: "127.0.0.1".to_owned(), namespace: None }
    }

    /// A command line that runs there.
    #[must_use]
    pub fn launch(&self, launch: Launch) -> Launch {
        let Some(namespace) = &self.namespace else { return launch };
        let mut arguments: Vec<String> = ["netns", "exec", namespace].map(str::to_owned).to_vec();
        arguments.push(launch.program.display().to_string());
        arguments.extend(launch.arguments);
        Launch { program: "ip".into(), arguments, ..launch }
    }
}

/// Namespaces on a bridge, deleted on drop.
#[derive(Debug)]
pub struct Network {
    /// Numbers of the subnet: 10.x.y.0/24.
    subnet: (u8, u8),
    places: usize,
}

impl Network {
    /// Makes this number of namespaces; `None` if that is not allowed.
    #[must_use]
    pub fn make(places: usize) -> Option<Self> {
        (0..ATTEMPTS).find_map(|_| {
            let random = RandomState::new().build_hasher().finish().to_le_bytes();
            let network = Self { subnet: (200 + random[0] % 50, random[1]), places };
            if !run(&["link", "add", &network.bridge(), "type", "bridge"]) {
                // It is another one's: nothing to delete.
                std::mem::forget(network);
                return None;
            }
            network.connect().then_some(network)
        })
    }

    fn connect(&self) -> bool {
        let bridge = self.bridge();
        let outside = format!("{}/24", self.outside());
        run(&["addr", "add", &outside, "dev", &bridge])
            && run(&["link", "set", &bridge, "up"])
            && (0..self.places).all(|at| self.connect_one(at))
    }

    fn connect_one(&self, at: usize) -> bool {
        let (name, outer, inner) = (self.name(at), self.interface(at, "o"), self.interface(at, "i"));
        let inside = format!("{}/24", self.host(at));
        run(&["netns", "add", &name])
            && run(&["link", "add", &outer, "type", "veth", "peer", "name", &inner])
            && run(&["link", "set", &inner, "netns", &name])
            && run(&["link", "set", &outer, "master", &self.bridge()])
            && run(&["link", "set", &outer, "up"])
            && run(&["-n", &name, "addr", "add", &inside, "dev", &inner])
            && run(&["-n", &name, "link", "set", &inner, "up"])
            && run(&["-n", &name, "link", "set", "lo", "up"])
    }

    fn bridge(&self) -> String {
        format!("vib{}-{}", self.subnet.0, self.subnet.1)
    }

    fn name(&self, at: usize) -> String {
        format!("vibrissa-{}-{}-{at}", self.subnet.0, self.subnet.1)
    }

    fn interface(&self, at: usize, side: &str) -> String {
        format!("vib{}-{}-{at}{side}", self.subnet.0, self.subnet.1)
    }

    /// Address of this machine on the bridge.
    #[must_use]
    pub fn outside(&self) -> String {
        format!("10.{}.{}.1", self.subnet.0, self.subnet.1)
    }

    fn host(&self, at: usize) -> String {
        format!("10.{}.{}.{}", self.subnet.0, self.subnet.1, at + 2)
    }

    /// This machine, as the namespaces reach it.
    #[must_use]
    pub fn here(&self) -> ServerAddress {
        ServerAddress { host: self.outside(), namespace: None }
    }

    /// A namespace by its number.
    #[must_use]
    pub fn place(&self, at: usize) -> ServerAddress {
        ServerAddress { host: self.host(at), namespace: Some(self.name(at)) }
    }

    /// Loses all packets from and to a namespace, or lets them pass again.
    ///
    /// # Panics
    /// The interface cannot be changed.
    pub fn cut(&self, at: usize, is_cut: bool) {
        let state = if is_cut { "down" } else { "up" };
        // The outer interface: addresses, routes and listeners of the namespace stay.
        let ended = run(&["link", "set", &self.interface(at, "o"), state]);
        assert!(ended, "the interface of {} cannot be set {state}", self.name(at));
    }

    /// Loses all packets from a namespace to others, or lets them pass again; the rest of the network stays in reach.
    ///
    /// # Panics
    /// The routes cannot be changed.
    pub fn separate(&self, at: usize, others: &[usize], is_separate: bool) {
        let name = self.name(at);
        let change = if is_separate { "add" } else { "del" };
        for &other in others {
            let host = format!("{}/32", self.host(other));
            let ended = run(&["-n", &name, "route", change, "blackhole", &host]);
            assert!(ended, "a route of {name} cannot be changed: {change}");
        }
    }
}

impl Drop for Network {
    fn drop(&mut self) {
        // This deletes the interfaces, too.
        for at in 0..self.places {
            run(&["netns", "delete", &self.name(at)]);
        }
        run(&["link", "delete", &self.bridge()]);
    }
}

fn run(arguments: &[&str]) -> bool {
    let mut ip = Command::new("ip");
    ip.args(arguments).stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|status| status.success())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether the other side refuses a connection: nobody listens there, but its refusal arrives.
    fn reaches(from: &ServerAddress, to: &str) -> bool {
        let connect = from.launch(Launch {
            program: "timeout".into(),
            arguments: ["1", "bash", "-c", &format!("</dev/tcp/{to}/9")].map(str::to_owned).to_vec(),
            environment: Vec::new(),
            log: "/dev/null".into(),
        });
        let output = Command::new(connect.program).args(connect.arguments).output().unwrap();
        String::from_utf8_lossy(&output.stderr).contains("refused")
    }

    #[test]
    fn places_reach_each_other_until_they_are_cut_off_or_separated() {
        let Some(network) = Network::make(3) else {
            println!("skipped: a network of namespaces needs root");
            return;
        };
        let [a, b, c] = [0, 1, 2].map(|at| network.place(at));
        assert!(reaches(&a, &b.host) && reaches(&a, &network.outside()) && reaches(&network.here(), &c.host));
        network.separate(0, &[1], true);
        assert!(!reaches(&a, &b.host) && !reaches(&b, &a.host) && reaches(&a, &c.host));
        network.separate(0, &[1], false);
        network.cut(2, true);
        assert!(reaches(&a, &b.host) && !reaches(&a, &c.host));
        network.cut(2, false);
        assert!(reaches(&a, &c.host));
    }
}
