//! What load is made.

use clap::ValueEnum;
use vibrissa_protocol::{CONTACTS_MAX, Name, WHISKERS_MAX};

/// The most robots: their names have six digits, and a supervisor takes no more of one fleet.
pub const ROBOTS_MAX: usize = 10_000;

/// How contacts are published.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Quality {
    /// At most once: the robot of the contract, which sends again by receipt.
    #[value(name = "0")]
    AtMostOnce,
    /// At least once.
    #[value(name = "1")]
    AtLeastOnce,
}

/// What load is made: which robots, what they send, and how fast.
#[derive(Debug, Clone, clap::Args)]
pub struct LoadPlan {
    /// The broker, in plain text: mqtt://host[:1883]
    #[arg(long, env = "VIBRISSA_MQTT_URL", default_value = "mqtt://127.0.0.1:1883")]
    pub mqtt_url: String,
    /// The fleet's name
    #[arg(long, default_value = "load")]
    pub fleet: Name,
    /// Robots, 1 to 10000
    #[arg(long, default_value_t = 100)]
    pub robots: usize,
    /// Whiskers of each robot
    #[arg(long, default_value_t = 10)]
    pub whiskers: usize,
    /// Whiskers of each of its arrays
    #[arg(long, default_value_t = 10)]
    pub array_whiskers: usize,
    /// Contacts messages of all robots together, without those of the preparation
    #[arg(long, default_value_t = 100_000)]
    pub messages: u64,
    /// Contacts in one message, 1 to 1000
    #[arg(long, default_value_t = 1)]
    pub contacts: usize,
    /// How contacts are published
    #[arg(long, value_enum, default_value = "1")]
    pub qos: Quality,
    /// Messages per second of all robots, by the clock whatever comes back; as fast as possible if left out
    #[arg(long)]
    pub rate: Option<f64>,
    /// Connections to the broker, among which the robots are shared out
    #[arg(long, default_value_t = 2)]
    pub connections: usize,
    /// Messages of QoS 1 that the broker has not acknowledged, of each connection
    #[arg(long, default_value_t = 1000)]
    pub window: usize,
    /// Messages without a receipt, of all robots together: beyond it a robot waits before it sends a new one. 16 for each
    /// robot if left out, but at least 16000
    #[arg(long)]
    pub unreceipted: Option<usize>,
    /// Nobody receipts: ends when the broker has got everything
    #[arg(long)]
    pub no_receipts: bool,
    /// Contacts of each whisker in the preparation, in messages of 20, so that it is learned what the whisker feels
    #[arg(long, default_value_t = 0)]
    pub learn: usize,
    /// Whiskers are cut one after the other on each robot, which gives every n-th of its contacts to the one that was cut
    /// last until a setpoint comes for it; the time from that contact to its setpoint is measured
    #[arg(long, value_name = "N")]
    pub trim_every: Option<u64>,
    /// Seconds between two statuses of a robot, up to 10 by the contract
    #[arg(long, default_value_t = 10.0)]
    pub status_every_s: f64,
    /// Give up when nothing comes back for so many seconds
    #[arg(long, default_value_t = 60.0)]
    pub patience_s: f64,
}

/// A plan that cannot be carried out: what is wrong with it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct BadPlan(String);

impl LoadPlan {
    /// Checks it as a whole.
    ///
    /// # Errors
    /// Something is out of the contract's limits or of the generator's.
    pub fn check(&self) -> Result<(), BadPlan> {
        let within = |what: &str, value: usize, most: usize| {
            let is_within = (1..=most).contains(&value);
            is_within.then_some(()).ok_or_else(|| BadPlan(format!("{what} must be 1 to {most}, not {value}")))
        };
        within("--robots", self.robots, ROBOTS_MAX)?;
        within("--array-whiskers", self.array_whiskers, WHISKERS_MAX)?;
        within("--whiskers", self.whiskers, vibrissa_protocol::ARRAYS_MAX * self.array_whiskers)?;
        within("--contacts", self.contacts, CONTACTS_MAX)?;
        within("--connections", self.connections, self.robots)?;
        within("--window", self.window, usize::from(u16::MAX) / 2)?;
        within("--unreceipted", self.unreceipted(), 100_000_000)?;
        if self.rate.is_some_and(|rate| rate.is_nan() || rate <= 0.0) {
            return Err(BadPlan("--rate must be above 0".to_owned()));
        }
        if !(0.1..=10.0).contains(&self.status_every_s) {
            return Err(BadPlan("--status-every-s must be 0.1 to 10".to_owned()));
        }
        let trims_well = self.contacts == 1 && self.array_whiskers == 1 && !self.no_receipts;
        if self.trim_every.is_some_and(|every| every == 0 || !trims_well) {
            let needs =
                "--trim-every needs a number above 0, one contact a message, one whisker an array, and receipts";
            return Err(BadPlan(needs.to_owned()));
        }
        Ok(())
    }

    /// Messages without a receipt, of all robots together.
    #[must_use]
    pub fn unreceipted(&self) -> usize {
        self.unreceipted.unwrap_or_else(|| (16 * self.robots).max(16_000))
    }

    /// A robot's name.
    ///
    /// # Panics
    /// Never: it is made of a letter and digits.
    #[must_use]
    pub fn robot(&self, number: usize) -> Name {
        Name::robot(&format!("r{number:06}")).expect("a name")
    }

    /// A whisker's array and its number there.
    #[must_use]
    pub fn place(&self, whisker: usize) -> (String, u16) {
        let number = u16::try_from(whisker % self.array_whiskers).unwrap_or(u16::MAX);
        (format!("a{}", whisker / self.array_whiskers), number)
    }
}
