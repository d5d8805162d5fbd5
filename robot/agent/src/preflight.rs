//! What a start would meet on this machine: devices, programs, sockets, ports and folders that the configuration names.
//!
//! `--check` refuses each. An agent that runs goes on instead: a board may be plugged in later.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::ErrorKind;
use std::net::TcpListener;
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};

use rustix::fs::{Access, OFlags, access};
use vibrissa_program::files::own_uid;
use vibrissa_protocol::plain;

use crate::config::{Config, DriverConfig, Way};
use crate::store::file::StoreFile;

/// Longest path of a socket, bytes, with the zero at its end left out.
const SOCKET_PATH_MAX: usize = 107;
/// Programs whose first argument is a file.
const INTERPRETERS: [&str; 8] = ["python3", "python", "node", "bash", "sh", "perl", "ruby", "lua"];
/// Bytes of a contact with its share of the message, in the outbox.
const CONTACT_BYTES: u64 = 170;

/// Problems of this machine with a configuration; empty if an agent would start and reach its drivers.
#[must_use]
pub fn problems(config: &Config) -> Vec<String> {
    let mut found = Vec::new();
    let is_running = config.outbox_file.as_deref().is_some_and(is_locked);
    found.extend(config.outbox_file.as_deref().and_then(outbox));
    for driver in &config.drivers {
        let problem = match &driver.way {
            Way::Command(words) => command(words, &driver.folder),
            Way::Unix(path) => socket(path, is_running),
            Way::Tcp(_) => None,
            Way::Listen(address) => port(address, is_running),
            Way::Serial(path, baud) => device(path, *baud, is_running),
        };
        found.extend(problem.map(|problem| format!("{}: {problem}", driver.label)));
    }
    found.extend(shared_device(&config.drivers));
    found
}

/// What `--check` says of a configuration that is in order.
#[must_use]
pub fn remarks(config: &Config) -> Vec<String> {
    let mut remarks = Vec::new();
    let memory = config.limits.outbox_bytes as u64;
    let disk = config.spool().map_or(0, |_| config.limits.outbox_disk_bytes);
    let hours = (memory + disk) as f64 / (240 * CONTACT_BYTES) as f64 / 3600.0;
    remarks.push(format!(
        "outbox: {} MiB in memory and {} MiB on disk, which is {hours:.1} hours of 240 contacts a second",
        memory >> 20,
        disk >> 20
    ));
    if let Some(free) =
        config.spool().as_deref().and_then(Path::parent).and_then(free_bytes).filter(|free| *free < disk)
    {
        remarks.push(format!("warning: outbox.disk_bytes is {} MiB, but only {} MiB are free", disk >> 20, free >> 20));
    }
    remarks.extend(rights(own_uid()));
    if config.outbox_file.as_deref().is_some_and(is_locked) {
        remarks.push("an agent runs with this outbox: whether devices and ports are free was not checked".to_owned());
    }
    remarks
}

/// Root can read what the service's user cannot.
fn rights(uid: u32) -> Option<String> {
    (uid == 0).then(|| {
        "files and devices were checked with the rights of root: check as the agent's user, too (sudo -u vibrissa-robot)".to_owned()
    })
}

fn free_bytes(folder: &Path) -> Option<u64> {
    let found = rustix::fs::statvfs(if folder.as_os_str().is_empty() { Path::new(".") } else { folder }).ok()?;
    Some(found.f_bavail * found.f_frsize)
}

/// Whether an agent has the outbox.
fn is_locked(path: &Path) -> bool {
    let mut lock = path.as_os_str().to_owned();
    lock.push(".lock");
    File::open(PathBuf::from(lock)).is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

fn outbox(path: &Path) -> Option<String> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Some(format!("outbox.file: {} is no folder: make it, for the agent's user", folder.display()));
    }
    if access(folder, Access::WRITE_OK | Access::EXEC_OK).is_err() {
        return Some(format!("outbox.file: files in {} cannot be written by this user", folder.display()));
    }
    StoreFile::check(path).err().map(|problem| problem.to_string())
}

fn command(words: &[String], folder: &Path) -> Option<String> {
    let (program, arguments) = words.split_first()?;
    if program.contains('/') {
        if !is_executable(Path::new(program)) {
            return Some(format!("driver.command: {program} is no program that this user can start"));
        }
    } else {
        let path = std::env::var_os("PATH").unwrap_or_default();
        if !std::env::split_paths(&path).any(|folder| is_executable(&folder.join(program))) {
            return Some(format!("driver.command: no program {program} in PATH"));
        }
    }
    let name = Path::new(program).file_name()?.to_str()?;
    let script = arguments.first().filter(|first| INTERPRETERS.contains(&name) && !first.starts_with('-'))?;
    let script = folder.join(script);
    match File::open(&script) {
        Ok(_) if script.is_file() => None,
        Ok(_) => Some(format!("driver.command: {} is no file", script.display())),
        Err(problem) => Some(format!("driver.command: cannot read {}: {}", script.display(), plain::io(&problem))),
    }
}

fn is_executable(path: &Path) -> bool {
    path.is_file() && access(path, Access::EXEC_OK).is_ok()
}

fn socket(path: &Path, is_running: bool) -> Option<String> {
    let shown = path.display();
    if path.as_os_str().len() > SOCKET_PATH_MAX {
        return Some(format!("driver.unix: {shown} has more than {SOCKET_PATH_MAX} bytes"));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if access(folder, Access::WRITE_OK | Access::EXEC_OK).is_err() {
        return Some(format!("driver.unix: this user cannot make a socket in {}", folder.display()));
    }
    let found = std::fs::symlink_metadata(path).ok()?;
    if !found.file_type().is_socket() {
        return Some(format!("driver.unix: {shown} exists and is no socket"));
    }
    (!is_running && UnixStream::connect(path).is_ok()).then(|| format!("driver.unix: {shown} is in use"))
}

fn port(address: &str, is_running: bool) -> Option<String> {
    let problem = TcpListener::bind(address).err()?;
    if is_running && problem.kind() == ErrorKind::AddrInUse {
        return None;
    }
    Some(format!("driver.listen: cannot listen at {address}: {}", plain::io(&problem)))
}

fn device(path: &Path, baud: u32, is_running: bool) -> Option<String> {
    let shown = path.display();
    let flags = OFlags::NONBLOCK | OFlags::NOCTTY;
    let opened = OpenOptions::new().read(true).write(true).custom_flags(flags.bits().cast_signed()).open(path);
    let file = match opened {
        Ok(file) => file,
        Err(problem) if problem.kind() == ErrorKind::PermissionDenied => {
            return Some(format!("driver.serial: this user may not open {shown}: add it to the group dialout"));
        }
        // The agent that runs has it to itself.
        Err(problem) if is_running && problem.kind() == ErrorKind::ResourceBusy => return None,
        Err(problem) => return Some(format!("driver.serial: cannot open {shown}: {}", plain::io(&problem))),
    };
    if let (Err(TryLockError::WouldBlock), false) = (file.try_lock_shared(), is_running) {
        return Some(format!("driver.serial: {shown} is in use by another program, such as another agent"));
    }
    let Ok(mut settings) = rustix::termios::tcgetattr(&file) else {
        return Some(format!("driver.serial: {shown} is no serial device"));
    };
    settings.set_speed(baud).err().map(|_| format!("driver.baud: {baud} is no speed that {shown} has"))
}

/// Two drivers whose paths are one device.
fn shared_device(drivers: &[DriverConfig]) -> Option<String> {
    let device = |driver: &DriverConfig| match &driver.way {
        Way::Serial(path, _) | Way::Unix(path) => path.canonicalize().ok(),
        Way::Command(_) | Way::Tcp(_) | Way::Listen(_) => None,
    };
    drivers.iter().enumerate().find_map(|(index, one)| {
        let path = device(one)?;
        let other = drivers[..index].iter().find(|other| device(other).as_ref() == Some(&path))?;
        Some(format!("{}: {} is the device of {}, too", one.label, path.display(), other.label))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::tests::EXAMPLE;

    #[test]
    fn regress_a_check_with_the_rights_of_root_says_so() {
        assert!(rights(0).is_some_and(|remark| remark.contains("sudo -u vibrissa-robot")));
        assert_eq!(rights(1000), None);
        let config = Config::from_toml_str(EXAMPLE, Path::new("")).unwrap();
        assert_eq!(remarks(&config).iter().any(|remark| remark.contains("rights of root")), own_uid() == 0);
    }

    #[test]
    fn regress_what_a_start_would_meet_is_refused_with_the_reason() {
        let folder = std::env::temp_dir().join(format!("vibrissa-preflight-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir(&folder).unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
        write("driver.py", "");
        write("plain", "text");
        let _socket = std::os::unix::net::UnixListener::bind(folder.join("used")).unwrap();
        let held = TcpListener::bind("127.0.0.1:0").unwrap();
        let listen = format!("listen = \"{}\"", held.local_addr().unwrap());
        let long = format!("unix = \"{}\"", "x".repeat(120));
        for (driver, problem) in [
            ("command = [\"python3\", \"driver.py\"]", ""),
            ("command = [\"python3\", \"missing.py\"]", "cannot read"),
            ("command = [\"python3\", \".\"]", "is no file"),
            ("command = [\"no-such-program-at-all\"]", "no program no-such-program-at-all in PATH"),
            ("command = [\"./plain\"]", "is no program that this user can start"),
            ("serial = \"missing\"", "cannot open"),
            ("serial = \"plain\"", "is no serial device"),
            ("unix = \"new\"", ""),
            ("unix = \"plain\"", "exists and is no socket"),
            ("unix = \"used\"", "is in use"),
            ("unix = \"no/folder\"", "cannot make a socket in"),
            (&long, "has more than 107 bytes"),
            ("listen = \"127.0.0.1:0\"", ""),
            (&listen, "cannot listen at"),
        ] {
            let text = EXAMPLE.replacen("command = [\"python3\", \"driver.py\"]", driver, 1);
            let found = problems(&Config::from_toml_str(&text, &folder).unwrap());
            assert_eq!(found.len(), usize::from(!problem.is_empty()), "{driver}: {found:?}");
            assert!(
                found.iter().all(|one| one.starts_with("the driver: driver.") && one.contains(problem)),
                "{found:?}"
            );
        }
        for (file, problem) in [("new", ""), ("no/folder", "is no folder"), ("plain", "is no outbox"), (".", "")] {
            let text = EXAMPLE.replacen("    [driver]", &format!("    [outbox]\nfile = \"{file}\"\n    [driver]"), 1);
            let found = problems(&Config::from_toml_str(&text, &folder).unwrap());
            let expected = usize::from(!problem.is_empty() || file == ".");
            assert_eq!(found.len(), expected, "{file}: {found:?}");
            assert!(found.iter().all(|one| one.starts_with("outbox.file: ") && one.contains(problem)), "{found:?}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
