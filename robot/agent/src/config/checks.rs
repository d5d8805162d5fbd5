//! Checks of the values, and their conversion.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::path::Path;

use vibrissa_protocol::text_file::read_text;
use vibrissa_protocol::{ARRAYS_MAX, ArrayFacts, CONTACTS_MAX, WHISKERS_MAX, WhiskerFacts};
use vibrissa_segmenter::Params;

use super::file::{File, FileArray, FileBroker, FileDriver, FileWhisker};
use super::{BadConfig, DriverConfig, Limits, Way};
use crate::exposure::is_loopback;
use crate::mqtt::{Authorities, Broker, ClientCertificate, password_in};

/// Size limit of the file with a driver's token, bytes.
const TOKEN_FILE_MAX_BYTES: u64 = 4096;

type Checked = Result<(), BadConfig>;

fn within(key: impl Into<String>, value: f64, range: RangeInclusive<f64>) -> Checked {
    if range.contains(&value) {
        return Ok(());
    }
    Err(BadConfig::OutOfRange { key: key.into(), value, least: *range.start(), most: *range.end() })
}

pub(super) fn unfitting(key: impl Into<String>, problem: impl Into<String>) -> BadConfig {
    BadConfig::Unfitting { key: key.into(), problem: problem.into() }
}

fn us(seconds: f64) -> u64 {
    (seconds * 1e6) as u64
}
pub(super) fn limits(file: &File) -> Result<Limits, BadConfig> {
    let (outbox, contacts, supervisor, driver) = (&file.outbox, &file.contacts, &file.supervisor, &file.driver);
    within("outbox.messages", outbox.messages as f64, 1.0..=1e6)?;
    within("outbox.bytes", outbox.bytes as f64, 65_536.0..=1e9)?;
    within("contacts.per_message", contacts.per_message as f64, 1.0..=CONTACTS_MAX.min(500) as f64)?;
    within("contacts.message_after_s", contacts.message_after_s, 0.01..=60.0)?;
    within("contacts.per_s_max", contacts.per_s_max, 1.0..=10_000.0)?;
    within("contacts.temperature_c", contacts.temperature_c, -100.0..=300.0)?;
    let segmenter = &file.segmenter;
    within("segmenter.least_strain", segmenter.least_strain, 0.0..=0.1)?;
    within("segmenter.strain_limit", segmenter.strain_limit, 1e-4..=1.0)?;
    within("segmenter.baseline_s", segmenter.baseline_s, 0.1..=60.0)?;
    within("segmenter.longest_s", segmenter.longest_s, 1.0..=600.0)?;
    within("supervisor.lost_after_s", supervisor.lost_after_s, 1.0..=86_400.0)?;
    within("supervisor.status_every_s", supervisor.status_every_s, 1.0..=10.0)?;
    within("driver.silent_s", driver.silent_s, 0.5..=600.0)?;
    within("driver.repeat_s", driver.repeat_s, 0.1..=60.0)?;
    within("driver.tolerance_mpa", driver.tolerance_mpa, 1e-5..=0.005)?;
    within("driver.settle_s", driver.settle_s, 0.05..=60.0)?;
    within("driver.fail_after_s", driver.fail_after_s, 0.5..=600.0)?;
    within("driver.own_slew_mpa_per_s", driver.own_slew_mpa_per_s, 1e-5..=10.0)?;
    Ok(Limits {
        outbox_messages: outbox.messages,
        outbox_bytes: outbox.bytes,
        contacts_per_message: contacts.per_message,
        message_after_us: us(contacts.message_after_s),
        contacts_per_s: contacts.per_s_max,
        status_every_us: us(supervisor.status_every_s),
        supervisor_lost_after_us: us(supervisor.lost_after_s),
        driver_silent_us: us(driver.silent_s),
        repeat_us: us(driver.repeat_s),
        tolerance_mpa: driver.tolerance_mpa,
        settle_us: us(driver.settle_s),
        fail_after_us: us(driver.fail_after_s),
        own_slew_mpa_per_s: driver.own_slew_mpa_per_s,
        temperature_c: contacts.temperature_c,
        regulate: driver.regulate,
        segmenter: Params {
            least_strain: segmenter.least_strain,
            strain_limit: segmenter.strain_limit,
            baseline_s: segmenter.baseline_s,
            longest_s: segmenter.longest_s,
            ..Params::default()
        },
    })
}

impl FileBroker {
    pub(super) fn checked(&self, folder: &Path) -> Result<Broker, BadConfig> {
        let mut broker = Broker::from_url(&self.url)?;
        if let Some(path) = &self.ca_file {
            if broker.tls.is_none() {
                return Err(unfitting("broker.ca_file", "requires mqtts:// in broker.url"));
            }
            broker.tls = Some(Authorities::File(folder.join(path)));
        }
        broker.client = match (&self.client_certificate_file, &self.client_key_file) {
            (None, None) => None,
            (Some(_), Some(_)) if self.ca_file.is_none() => {
                return Err(unfitting("broker.client_certificate_file", "needs broker.ca_file"));
            }
            (Some(certificate), Some(key)) => {
                Some(ClientCertificate { certificate_file: folder.join(certificate), key_file: folder.join(key) })
            }
            (Some(_), None) => {
                return Err(unfitting("broker.client_certificate_file", "needs broker.client_key_file"));
            }
            (None, Some(_)) => {
                return Err(unfitting("broker.client_key_file", "needs broker.client_certificate_file"));
            }
        };
        broker.password_file = self.password_file.as_ref().map(|path| folder.join(path));
        broker.credentials = match (&self.username, &broker.password_file) {
            (None, None) => None,
            (Some(user), Some(path)) => Some((user.clone(), password_in(path)?)),
            (Some(_), None) => return Err(unfitting("broker.username", "needs broker.password_file")),
            (None, Some(_)) => return Err(unfitting("broker.password_file", "needs broker.username")),
        };
        Ok(broker)
    }
}

impl FileDriver {
    pub(super) fn checked(self, folder: &Path) -> Result<DriverConfig, BadConfig> {
        if self.baud.is_some() && self.serial.is_none() {
            return Err(unfitting("driver.baud", "needs driver.serial"));
        }
        let mut ways = Vec::new();
        ways.extend(self.command.map(Way::Command));
        ways.extend(self.unix.map(|path| Way::Unix(folder.join(path))));
        ways.extend(self.tcp.map(Way::Tcp));
        ways.extend(self.listen.map(Way::Listen));
        ways.extend(self.serial.map(|path| Way::Serial(path, self.baud.unwrap_or(115_200))));
        let (Some(way), None) = (ways.pop(), ways.pop()) else {
            return Err(unfitting("driver", "needs exactly one of command, unix, tcp, listen and serial"));
        };
        match &way {
            Way::Command(words) if words.first().is_none_or(String::is_empty) => {
                return Err(unfitting("driver.command", "must begin with a program"));
            }
            Way::Listen(address) => {
                let address: Option<std::net::SocketAddr> = address.parse().ok();
                if !address.is_some_and(|address| address.ip().is_loopback()) {
                    return Err(unfitting("driver.listen", "must be a loopback address and a port, as 127.0.0.1:5555"));
                }
            }
            Way::Command(_) | Way::Unix(_) | Way::Tcp(_) | Way::Serial(..) => {}
        }
        let token_file = self.token_file.map(|path| folder.join(path));
        let token = token_file.as_deref().map(token_in).transpose()?;
        if token.is_some() && !matches!(way, Way::Tcp(_) | Way::Listen(_)) {
            return Err(unfitting("driver.token_file", "needs driver.tcp or driver.listen"));
        }
        if let Way::Tcp(address) = &way
            && token.is_none()
            && !is_loopback(address.rsplit_once(':').map_or(address.as_str(), |(host, _)| host))
        {
            let problem = "needs driver.token_file: beyond this machine nobody knows who answers";
            return Err(unfitting("driver.tcp", problem));
        }
        Ok(DriverConfig { way, restart: self.restart, token, token_file })
    }
}

/// The token in a file, without the line break at its end.
fn token_in(path: &Path) -> Result<String, BadConfig> {
    let text = read_text(path, TOKEN_FILE_MAX_BYTES)
        .map_err(|problem| unfitting("driver.token_file", format!("cannot read {}: {problem}", path.display())))?;
    let token = text.trim_end_matches(['\n', '\r']);
    let is_fit = (16..=256).contains(&token.len()) && token.chars().all(|one| one.is_ascii_graphic());
    if !is_fit {
        let problem =
            "must contain 16 to 256 printable characters without spaces, such as those of openssl rand -hex 16";
        return Err(unfitting("driver.token_file", problem));
    }
    Ok(token.to_owned())
}

pub(super) fn arrays(arrays: Vec<FileArray>) -> Result<Vec<ArrayFacts>, BadConfig> {
    within("number of arrays", arrays.len() as f64, 1.0..=ARRAYS_MAX as f64)?;
    let mut names = BTreeSet::new();
    let mut facts = Vec::with_capacity(arrays.len());
    for array in arrays {
        let place = format!("array {}", array.array);
        if !names.insert(array.array.clone()) {
            return Err(unfitting(place, "occurs more than once"));
        }
        within(format!("{place}: number of whiskers"), array.whiskers.len() as f64, 1.0..=WHISKERS_MAX as f64)?;
        let numbers: BTreeSet<u16> = array.whiskers.iter().map(|whisker| whisker.whisker).collect();
        if numbers.len() < array.whiskers.len() {
            return Err(unfitting(place, "has two whiskers with one number"));
        }
        let whiskers = array.whiskers.into_iter().map(|whisker| whisker.checked(&place, &numbers));
        facts.push(ArrayFacts {
            array: array.array,
            array_type: array.array_type,
            task: array.task,
            whiskers: whiskers.collect::<Result<_, _>>()?,
        });
    }
    Ok(facts)
}

impl FileWhisker {
    pub(super) fn checked(self, array: &str, numbers: &BTreeSet<u16>) -> Result<WhiskerFacts, BadConfig> {
        let key = |name: &str| format!("{array} whisker {} {name}", self.whisker);
        within(key("x_mm"), self.x_mm, -100_000.0..=100_000.0)?;
        within(key("y_mm"), self.y_mm, -100_000.0..=100_000.0)?;
        within(key("length_mm"), self.length_mm, 1.0..=1000.0)?;
        within(key("pressure_max_mpa"), self.pressure_max_mpa, 0.0..=0.2)?;
        within(key("pressure_mpa"), self.pressure_mpa, 0.0..=self.pressure_max_mpa)?;
        if let Some(strain_max) = self.strain_max {
            within(key("strain_max"), strain_max, 1e-6..=1.0)?;
        }
        if !(1..=64).contains(&self.model.chars().count()) || self.model.chars().any(char::is_control) {
            return Err(unfitting(key("model"), "must have 1 to 64 characters, none of them a control character"));
        }
        for neighbour in &self.neighbours {
            if *neighbour == self.whisker || !numbers.contains(neighbour) {
                return Err(unfitting(key("neighbours"), format!("{neighbour} is not another whisker of this array")));
            }
        }
        Ok(WhiskerFacts {
            whisker: self.whisker,
            x_mm: self.x_mm,
            y_mm: self.y_mm,
            model: self.model,
            length_mm: self.length_mm,
            pressure_mpa: self.pressure_mpa,
            pressure_max_mpa: self.pressure_max_mpa,
            neighbours: self.neighbours,
            place: self.place,
            strain_max: self.strain_max,
        })
    }
}
