//! Checks of the values, and their conversion.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;
use std::path::Path;

use vibrissa_protocol::{ARRAYS_MAX, ArrayFacts, CONTACTS_MAX, Name, WHISKERS_MAX, WhiskerFacts};
use vibrissa_segmenter::Params;

use super::file::{File, FileArray, FileBroker, FileWhisker};
use super::{BadConfig, Limits, WhiskerConfig};
use crate::mqtt::{Authorities, Broker, ClientCertificate, password_in};

pub(super) type Checked = Result<(), BadConfig>;

pub(super) fn within(key: impl Into<String>, value: f64, range: RangeInclusive<f64>) -> Checked {
    if range.contains(&value) {
        return Ok(());
    }
    Err(BadConfig::OutOfRange { key: key.into(), value, least: *range.start(), most: *range.end() })
}

pub(super) fn unfitting(key: impl Into<String>, problem: impl Into<String>) -> BadConfig {
    BadConfig::Unfitting { key: key.into(), problem: problem.into() }
}

pub(super) fn us(seconds: f64) -> u64 {
    (seconds * 1e6) as u64
}

pub(super) fn limits(file: &File) -> Result<Limits, BadConfig> {
    let (outbox, contacts, supervisor) = (&file.outbox, &file.contacts, &file.supervisor);
    within("outbox.messages", outbox.messages as f64, 1.0..=1e6)?;
    within("outbox.bytes", outbox.bytes as f64, 65_536.0..=1e9)?;
    if outbox.disk_bytes > 0 {
        within("outbox.disk_bytes (0 for none)", outbox.disk_bytes as f64, 16e6..=1e12)?;
    }
    within("contacts.per_message", contacts.per_message as f64, 1.0..=CONTACTS_MAX.min(500) as f64)?;
    within("contacts.message_after_s", contacts.message_after_s, 0.01..=60.0)?;
    within("contacts.per_s_max", contacts.per_s_max, 1.0..=10_000.0)?;
    within("contacts.temperature_c", contacts.temperature_c, -100.0..=300.0)?;
    let segmenter = &file.segmenter;
    within("segmenter.least_strain", segmenter.least_strain, 0.0..=0.1)?;
    within("segmenter.strain_limit", segmenter.strain_limit, 1e-4..=1.0)?;
    within("segmenter.baseline_s", segmenter.baseline_s, 0.1..=60.0)?;
    within("segmenter.longest_s", segmenter.longest_s, 1.0..=600.0)?;
    if segmenter.least_strain >= segmenter.strain_limit {
        return Err(unfitting("segmenter.least_strain", "must be below segmenter.strain_limit"));
    }
    within("supervisor.lost_after_s", supervisor.lost_after_s, 1.0..=86_400.0)?;
    within("supervisor.status_every_s", supervisor.status_every_s, 1.0..=10.0)?;
    Ok(Limits {
        outbox_messages: outbox.messages,
        outbox_bytes: outbox.bytes,
        outbox_disk_bytes: outbox.disk_bytes,
        contacts_per_message: contacts.per_message,
        message_after_us: us(contacts.message_after_s),
        contacts_per_s: contacts.per_s_max,
        status_every_us: us(supervisor.status_every_s),
        supervisor_lost_after_us: us(supervisor.lost_after_s),
        temperature_c: contacts.temperature_c,
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

/// Properties of each whisker that the factsheet does not have.
pub(super) fn whiskers(arrays: &[FileArray]) -> BTreeMap<(Name, u16), WhiskerConfig> {
    let of = |array: &FileArray| {
        let name = array.array.clone();
        let whisker = move |one: &FileWhisker| {
            let config = WhiskerConfig { sign: one.segmenter.sign, pressure_zero_mpa: one.pressure_zero_mpa };
            ((name.clone(), one.whisker), config)
        };
        array.whiskers.iter().map(whisker).collect::<Vec<_>>()
    };
    arrays.iter().flat_map(of).collect()
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
        within(key("pressure_zero_mpa"), self.pressure_zero_mpa, -0.01..=0.01)?;
        if let Some(tolerance_mm) = self.length_tolerance_mm {
            within(key("length_tolerance_mm"), tolerance_mm, 0.0..=20.0)?;
        }
        if let Some(strain_max) = self.strain_max {
            within(key("strain_max"), strain_max, 1e-6..=1.0)?;
        }
        if !(1..=64).contains(&self.model.chars().count()) || self.model.chars().any(char::is_control) {
            return Err(unfitting(key("model"), "must have 1 to 64 characters, none of them a control character"));
        }
        if self.neighbours.iter().collect::<BTreeSet<_>>().len() < self.neighbours.len() {
            return Err(unfitting(key("neighbours"), "names a whisker twice"));
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
            length_tolerance_mm: self.length_tolerance_mm,
            pressure_mpa: self.pressure_mpa,
            pressure_max_mpa: self.pressure_max_mpa,
            neighbours: self.neighbours,
            place: self.place,
            strain_max: self.strain_max,
        })
    }
}
