//! Checks of the drivers: the way to each, its whiskers, and what two of them cannot share.

use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use vibrissa_protocol::text_file::read_text;
use vibrissa_protocol::{ArrayFacts, Name};

use super::checks::{unfitting, us, within};
use super::file::{Drivers, FileDriver};
use super::{BadConfig, DriverConfig, DriverLimits, Way};
use crate::exposure::is_loopback;

/// Size limit of the file with a driver's token, bytes.
const TOKEN_FILE_MAX_BYTES: u64 = 4096;
/// Most drivers of a robot. Each has a task and a queue of lines.
const DRIVERS_MAX: usize = 64;

/// Array and number of a whisker.
type Place = (Name, u16);

impl Drivers {
    /// Replaces the way to the one driver by a socket at which this process, the driver, connects.
    pub(super) fn driven_at(&mut self, socket: PathBuf) -> Result<(), BadConfig> {
        if self.drivers.is_empty() {
            self.drivers.extend(toml::from_str::<FileDriver>("").ok());
        }
        let [driver] = self.drivers.as_mut_slice() else {
            return Err(unfitting("driver", "must be one table, because this program is the only driver"));
        };
        if driver.regulate {
            return Err(unfitting(
                "driver.regulate",
                "must be left out: this program gets pressures, and cannot open valves",
            ));
        }
        (driver.command, driver.tcp, driver.listen, driver.serial) = (None, None, None, None);
        (driver.baud, driver.token_file) = (None, None);
        driver.unix = Some(socket);
        Ok(())
    }

    /// Whether a driver has a way, or one is missing: several drivers need ways.
    pub(super) fn has_way(&self) -> bool {
        let has_way = |one: &FileDriver| {
            one.command.is_some()
                || one.unix.is_some()
                || one.tcp.is_some()
                || one.listen.is_some()
                || one.serial.is_some()
                || one.regulate
        };
        self.drivers.len() > 1 || self.drivers.iter().any(has_way)
    }

    /// Checks each driver, and all together: each whisker needs one, and two cannot share a name or a way.
    pub(super) fn checked(self, folder: &Path, arrays: &[ArrayFacts]) -> Result<Vec<DriverConfig>, BadConfig> {
        if self.drivers.is_empty() {
            return Err(unfitting("driver", "is missing: it names the way to the driver"));
        }
        within("number of drivers", self.drivers.len() as f64, 1.0..=DRIVERS_MAX as f64)?;
        let all: BTreeSet<Place> = arrays
            .iter()
            .flat_map(|array| array.whiskers.iter().map(|whisker| (array.array.clone(), whisker.whisker)))
            .collect();
        let mut drivers: Vec<DriverConfig> = Vec::with_capacity(self.drivers.len());
        for (index, file) in self.drivers.into_iter().enumerate() {
            let name = file.name.as_ref().map(Name::as_str);
            let (key, label) = match (name, self.is_list) {
                (Some(name), _) => (format!("driver {name}: driver"), format!("driver {name}")),
                (None, true) => (format!("driver {}: driver", index + 1), format!("driver {}", index + 1)),
                (None, false) => ("driver".to_owned(), "the driver".to_owned()),
            };
            let driver = file.checked(&key, label, folder, &all)?;
            if let Some(other) = drivers.iter().find(|other| other.label == driver.label) {
                return Err(unfitting(format!("{key}.name"), format!("{} occurs twice", other.label)));
            }
            // Two programs with one command may serve different whiskers by their arguments, and equal ones would not.
            if let Some(other) = drivers.iter().find(|other| other.way == driver.way) {
                return Err(unfitting(key, format!("has the way of {}: one driver has one way", other.label)));
            }
            drivers.push(driver);
        }
        if let Some((array, whisker)) =
            all.iter().find(|place| !drivers.iter().any(|driver| driver.whiskers.contains(*place)))
        {
            let problem = format!("no driver serves whisker {array}/{whisker}");
            return Err(unfitting("driver.whiskers", problem));
        }
        Ok(drivers)
    }
}

impl FileDriver {
    fn checked(
        self,
        key: &str,
        label: String,
        folder: &Path,
        all: &BTreeSet<Place>,
    ) -> Result<DriverConfig, BadConfig> {
        let limits = self.limits(key)?;
        let whiskers = match &self.whiskers {
            None => all.clone(),
            Some(names) => whiskers(key, names, all)?,
        };
        let restart = self.restart;
        let token_file = self.token_file.as_ref().map(|path| folder.join(path));
        let token = token_file.as_deref().map(|path| token_in(key, path)).transpose()?;
        let way = self.way(key, folder)?;
        if token.is_some() && !matches!(way, Way::Tcp(_) | Way::Listen(_)) {
            return Err(unfitting(format!("{key}.token_file"), "needs driver.tcp or driver.listen"));
        }
        if let Way::Tcp(address) = &way
            && token.is_none()
            && !is_loopback(address.rsplit_once(':').map_or(address.as_str(), |(host, _)| host))
        {
            let problem = "needs driver.token_file: beyond this machine nobody knows who answers";
            return Err(unfitting(format!("{key}.tcp"), problem));
        }
        Ok(DriverConfig { label, way, folder: folder.to_owned(), whiskers, limits, restart, token, token_file })
    }

    fn limits(&self, key: &str) -> Result<DriverLimits, BadConfig> {
        let named = |name: &str| format!("{key}.{name}");
        within(named("silent_s"), self.silent_s, 0.5..=600.0)?;
        within(named("repeat_s"), self.repeat_s, 0.1..=60.0)?;
        within(named("tolerance_mpa"), self.tolerance_mpa, 1e-5..=0.005)?;
        within(named("settle_s"), self.settle_s, 0.05..=60.0)?;
        within(named("fail_after_s"), self.fail_after_s, 0.5..=600.0)?;
        within(named("own_slew_mpa_per_s"), self.own_slew_mpa_per_s, 1e-5..=10.0)?;
        if self.settle_s >= self.fail_after_s {
            return Err(unfitting(
                named("settle_s"),
                "must be below driver.fail_after_s: no setpoint would be applied",
            ));
        }
        Ok(DriverLimits {
            silent_us: us(self.silent_s),
            repeat_us: us(self.repeat_s),
            tolerance_mpa: self.tolerance_mpa,
            settle_us: us(self.settle_s),
            fail_after_us: us(self.fail_after_s),
            own_slew_mpa_per_s: self.own_slew_mpa_per_s,
            regulate: self.regulate,
        })
    }

    fn way(self, key: &str, folder: &Path) -> Result<Way, BadConfig> {
        let named = |name: &str| format!("{key}.{name}");
        match self.baud {
            Some(_) if self.serial.is_none() => return Err(unfitting(named("baud"), "needs driver.serial")),
            Some(baud) => within(named("baud"), f64::from(baud), 50.0..=4_000_000.0)?,
            None => {}
        }
        let mut ways = Vec::new();
        ways.extend(self.command.map(|words| Way::Command(located(words, folder))));
        ways.extend(self.unix.map(|path| Way::Unix(folder.join(path))));
        ways.extend(self.tcp.map(Way::Tcp));
        ways.extend(self.listen.map(Way::Listen));
        ways.extend(self.serial.map(|path| Way::Serial(folder.join(path), self.baud.unwrap_or(115_200))));
        let (Some(way), None) = (ways.pop(), ways.pop()) else {
            return Err(unfitting(key, "needs exactly one of command, unix, tcp, listen and serial"));
        };
        match &way {
            Way::Command(words) if words.first().is_none_or(String::is_empty) => {
                return Err(unfitting(named("command"), "must begin with a program"));
            }
            Way::Listen(address) => {
                let address: Option<SocketAddr> = address.parse().ok();
                if !address.is_some_and(|address| address.ip().is_loopback()) {
                    return Err(unfitting(named("listen"), "must be a loopback address and a port, as 127.0.0.1:5555"));
                }
            }
            Way::Tcp(address) if !has_port(address) => {
                return Err(unfitting(named("tcp"), "must be a host and a port, as 127.0.0.1:5555"));
            }
            Way::Unix(path) | Way::Serial(path, _) if path.as_path() == folder => {
                return Err(unfitting(key, "names an empty path"));
            }
            Way::Command(_) | Way::Unix(_) | Way::Tcp(_) | Way::Serial(..) => {}
        }
        Ok(way)
    }
}

/// A command whose program is found from the folder of the file. A program without a folder is found by PATH.
fn located(mut words: Vec<String>, folder: &Path) -> Vec<String> {
    if let Some(program) = words.first_mut()
        && program.contains('/')
    {
        *program = folder.join(PathBuf::from(&*program)).to_string_lossy().into_owned();
    }
    words
}

fn has_port(address: &str) -> bool {
    address
        .rsplit_once(':')
        .is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok_and(|port| port > 0))
}

/// The whiskers that a list names: `ARRAY/NUMBER`, or `ARRAY` for all of an array.
fn whiskers(key: &str, names: &[String], all: &BTreeSet<Place>) -> Result<BTreeSet<Place>, BadConfig> {
    let key = format!("{key}.whiskers");
    let mut found = BTreeSet::new();
    for name in names {
        let (array, number) =
            name.split_once('/').map_or((name.as_str(), None), |(array, number)| (array, Some(number)));
        let is_named =
            |place: &&Place| place.0.as_str() == array && number.is_none_or(|number| number.parse() == Ok(place.1));
        let before = found.len();
        let named: BTreeSet<Place> = all.iter().filter(is_named).cloned().collect();
        if named.is_empty() {
            return Err(unfitting(
                key,
                format!("{name:?} is no whisker of the robot, such as \"left/0\", and no array"),
            ));
        }
        let count = named.len();
        found.extend(named);
        if found.len() < before + count {
            return Err(unfitting(key, format!("{name:?} is named twice")));
        }
    }
    if found.is_empty() {
        return Err(unfitting(key, "names no whisker: leave it out for all"));
    }
    Ok(found)
}

/// The token in a file, without the line break at its end.
fn token_in(key: &str, path: &Path) -> Result<String, BadConfig> {
    let key = format!("{key}.token_file");
    let text = read_text(path, TOKEN_FILE_MAX_BYTES)
        .map_err(|problem| unfitting(key.clone(), format!("cannot read {}: {problem}", path.display())))?;
    let token = text.trim_end_matches(['\n', '\r']);
    let is_fit = (16..=256).contains(&token.len()) && token.chars().all(|one| one.is_ascii_graphic());
    if !is_fit {
        let problem =
            "must contain 16 to 256 printable characters without spaces, such as those of openssl rand -hex 16";
        return Err(unfitting(key, problem));
    }
    Ok(token.to_owned())
}
