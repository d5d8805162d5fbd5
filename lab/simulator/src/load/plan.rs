//! Parameters of the load.

use clap::ValueEnum;
use vibrissa_protocol::{CONTACTS_MAX, Name, WHISKERS_MAX};

use vibrissa_program::options::{above_zero, number, whole};

/// Largest number of robots: their names have six digits, and a supervisor accepts no more in a fleet.
pub const ROBOTS_MAX: usize = 10_000;
/// Largest number of unreceipted messages.
const UNRECEIPTED_MAX: usize = 100_000_000;

/// Quality of service of contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Quality {
    /// At most once: robots that send again without a receipt.
    #[value(name = "0")]
    AtMostOnce,
    /// At least once: the broker acknowledges each message.
    #[value(name = "1")]
    AtLeastOnce,
}

/// Parameters of the load: robots, messages, and rate.
#[derive(Debug, Clone, clap::Args)]
pub struct LoadPlan {
    /// Broker URL, without TLS: mqtt://host[:1883]
    #[arg(long, env = "VIBRISSA_MQTT_URL", default_value = "mqtt://127.0.0.1:1883")]
    pub mqtt_url: String,
    /// Name of the fleet
    #[arg(long, default_value = "load")]
    pub fleet: Name,
    /// Number of robots, 1 to 10000
    #[arg(long, default_value_t = 100, value_parser = whole(1..=ROBOTS_MAX))]
    pub robots: usize,
    /// Whiskers per robot
    #[arg(long, default_value_t = 10, value_parser = whole(1..=vibrissa_protocol::ARRAYS_MAX * WHISKERS_MAX))]
    pub whiskers: usize,
    /// Whiskers per array
    #[arg(long, default_value_t = 10, value_parser = whole(1..=WHISKERS_MAX))]
    pub array_whiskers: usize,
    /// Contacts messages of all robots together, without those of the preparation
    #[arg(long, default_value_t = 100_000, value_parser = whole(0..=u64::MAX))]
    pub messages: u64,
    /// Contacts per message, 1 to 1000
    #[arg(long, default_value_t = 1, value_parser = whole(1..=CONTACTS_MAX))]
    pub contacts: usize,
    /// Quality of service of contacts
    #[arg(long, value_enum, default_value = "1")]
    pub qos: Quality,
    /// Messages per second of all robots together, regardless of receipts; default: as fast as possible
    #[arg(long, value_parser = above_zero)]
    pub rate: Option<f64>,
    /// Connections to the broker, which the robots share
    #[arg(long, default_value_t = 2, value_parser = whole(1..=ROBOTS_MAX))]
    pub connections: usize,
    /// Unacknowledged QoS 1 messages per connection
    #[arg(long, default_value_t = 1000, value_parser = whole(1..=usize::from(u16::MAX) / 2))]
    pub window: usize,
    /// Unreceipted messages of all robots together, beyond which robots send no new ones; default: 16 per robot,
    /// but at least 16000
    #[arg(long, value_parser = whole(1..=UNRECEIPTED_MAX))]
    pub unreceipted: Option<usize>,
    /// Expect no receipts: end when the broker has received all messages
    #[arg(long)]
    pub no_receipts: bool,
    /// Send contacts in CBOR instead of JSON
    #[arg(long)]
    pub cbor: bool,
    /// Publish nothing with the retain flag, which brokers that retain no messages refuse; robots answer requests for births
    #[arg(long)]
    pub no_retained: bool,
    /// Contacts per whisker in the preparation, in messages of 20, to train the supervisor's estimates
    #[arg(long, default_value_t = 0, value_parser = whole(0..=usize::MAX))]
    pub learn: usize,
    /// Cut whiskers one after the other on each robot; every N-th contact goes to the whisker cut last until a
    /// setpoint arrives, and the time from the contact to its setpoint is measured
    #[arg(long, value_name = "N", value_parser = whole(1..=u64::MAX))]
    pub trim_every: Option<u64>,
    /// Seconds between two statuses of a robot, at most 10 by the contract
    #[arg(long, default_value_t = 10.0, value_parser = number(0.1..=10.0))]
    pub status_every_s: f64,
    /// Give up after this many seconds without an answer
    #[arg(long, default_value_t = 60.0, value_parser = above_zero)]
    pub patience_s: f64,
}

/// An invalid plan, with the reason.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct BadPlan(String);

impl LoadPlan {
    /// Checks the plan as a whole.
    ///
    /// # Errors
    /// A value exceeds the limits of the contract or of the generator.
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
        within("--unreceipted", self.unreceipted(), UNRECEIPTED_MAX)?;
        if self.rate.is_some_and(|rate| rate.is_nan() || rate <= 0.0) {
            return Err(BadPlan("--rate must be above 0".to_owned()));
        }
        if !(0.1..=10.0).contains(&self.status_every_s) {
            return Err(BadPlan("--status-every-s must be 0.1 to 10".to_owned()));
        }
        let trims_well = self.contacts == 1 && self.array_whiskers == 1 && !self.no_receipts;
        if self.trim_every.is_some_and(|every| every == 0 || !trims_well) {
            let needs =
                "--trim-every needs a number above 0, one contact per message, one whisker per array, and receipts";
            return Err(BadPlan(needs.to_owned()));
        }
        Ok(())
    }

    /// Largest number of unreceipted messages of all robots together.
    #[must_use]
    pub fn unreceipted(&self) -> usize {
        self.unreceipted.unwrap_or_else(|| (16 * self.robots).max(16_000))
    }

    /// Name of a robot.
    ///
    /// # Panics
    /// Never: the name consists of a letter and digits.
    #[must_use]
    pub fn robot(&self, number: usize) -> Name {
        Name::robot(&format!("r{number:06}")).expect("a name")
    }

    /// Array of a whisker, and its number there.
    #[must_use]
    pub fn place(&self, whisker: usize) -> (String, u16) {
        let number = u16::try_from(whisker % self.array_whiskers).unwrap_or(u16::MAX);
        (format!("a{}", whisker / self.array_whiskers), number)
    }
}
