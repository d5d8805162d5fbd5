//! A network namespace, connected by a pair of virtual interfaces that can be cut. It needs root.

use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};
use std::process::{Command, Stdio};

/// Attempts to find a free name and subnet.
const ATTEMPTS: usize = 5;

/// A namespace, deleted on drop.
#[derive(Debug)]
pub(super) struct Network {
    /// Numbers of the subnet: 10.x.y.0/30.
    subnet: (u8, u8),
}

impl Network {
    /// Makes a namespace; `None` if that is not allowed.
    pub(super) fn make() -> Option<Self> {
        (0..ATTEMPTS).find_map(|_| {
            let random = RandomState::new().build_hasher().finish().to_le_bytes();
            let network = Self { subnet: (200 + random[0] % 50, random[1]) };
            let exists = run(&["link", "show", &network.interface("o")]);
            if exists || !run(&["netns", "add", &network.name()]) {
                // It is another one's: nothing to delete.
                std::mem::forget(network);
                return None;
            }
            network.connect().then_some(network)
        })
    }

    fn connect(&self) -> bool {
        let (name, outer, inner) = (self.name(), self.interface("o"), self.interface("i"));
        let (outside, inside) = (format!("{}/30", self.outside()), format!("{}/30", self.inside()));
        let within = ["netns", "exec", &name, "ip"];
        run(&["link", "add", &outer, "type", "veth", "peer", "name", &inner])
            && run(&["link", "set", &inner, "netns", &name])
            && run(&["addr", "add", &outside, "dev", &outer])
            && run(&["link", "set", &outer, "up"])
            && run(&[&within[..], &["addr", "add", &inside, "dev", &inner]].concat())
            && run(&[&within[..], &["link", "set", &inner, "up"]].concat())
            && run(&[&within[..], &["link", "set", "lo", "up"]].concat())
    }

    /// Name of the namespace.
    pub(super) fn name(&self) -> String {
        format!("vibrissa-{}-{}", self.subnet.0, self.subnet.1)
    }

    fn interface(&self, side: &str) -> String {
        format!("vib{}-{}{side}", self.subnet.0, self.subnet.1)
    }

    /// Address of this side.
    pub(super) fn outside(&self) -> String {
        format!("10.{}.{}.1", self.subnet.0, self.subnet.1)
    }

    /// Address in the namespace.
    pub(super) fn inside(&self) -> String {
        format!("10.{}.{}.2", self.subnet.0, self.subnet.1)
    }

    /// Loses all packets, or lets them pass again.
    pub(super) fn cut(&self, is_cut: bool) {
        // The inner interface, so that addresses and listeners of this side stay.
        let state = if is_cut { "down" } else { "up" };
        let ended = run(&["netns", "exec", &self.name(), "ip", "link", "set", &self.interface("i"), state]);
        assert!(ended, "the interface of {} cannot be set {state}", self.name());
    }
}

impl Drop for Network {
    fn drop(&mut self) {
        // This deletes the interfaces, too.
        run(&["netns", "delete", &self.name()]);
    }
}

fn run(arguments: &[&str]) -> bool {
    let mut ip = Command::new("ip");
    ip.args(arguments).stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|status| status.success())
}
