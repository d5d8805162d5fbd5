//! The file of `limits.robots_file`: which robots may be in which fleets, `FLEET/ROBOT` on each line.

use std::collections::{BTreeMap, HashSet};
use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use tokio::sync::watch;
use tokio::time::{Duration, timeout};
use tracing::{info, warn};
use vibrissa_host::task;
use vibrissa_protocol::text_file::read_text;
use vibrissa_protocol::{Name, plain};

/// Size limit of the file in bytes: about 100,000 names of full length.
const BYTES_MAX: u64 = 16 * 1024 * 1024;
/// Interval between two checks whether the file has changed.
const LOOK_EVERY: Duration = Duration::from_secs(2);

/// The robots that a file allows, by fleet.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RobotsFile(BTreeMap<Name, Arc<HashSet<Name>>>);

impl RobotsFile {
    /// Reads and parses a file.
    ///
    /// # Errors
    /// The file cannot be read, is too long, or has a line that is not `FLEET/ROBOT`; the text says which.
    pub fn read(path: &Path) -> Result<Self, String> {
        Self::read_with_stamp(path).map(|(file, _)| file)
    }

    fn read_with_stamp(path: &Path) -> Result<(Self, Stamp), String> {
        let shown = path.display();
        let failed = |problem: std::io::Error| format!("the file {shown} cannot be read: {}", plain::io(&problem));
        // A change after this is noticed at the next look.
        let stamp = Stamp::of(&std::fs::metadata(path).map_err(failed)?);
        let text = read_text(path, BYTES_MAX).map_err(failed)?;
        Self::parse(&text).map(|file| (file, stamp)).map_err(|problem| format!("the file {shown}, {problem}"))
    }

    /// Parses the text of a file: `FLEET/ROBOT` on each line; `#` begins a comment, and empty lines are skipped.
    ///
    /// # Errors
    /// The first line of another form, with its number.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut fleets: BTreeMap<Name, HashSet<Name>> = BTreeMap::new();
        for (line, number) in text.lines().zip(1..) {
            let entry = line.split('#').next().unwrap_or_default().trim();
            if entry.is_empty() {
                continue;
            }
            let named = |problem: vibrissa_protocol::BadName| format!("line {number}: {problem}");
            let (fleet, robot) = entry.split_once('/').ok_or_else(|| {
                let shown: String = entry.chars().take(80).collect();
                format!("line {number}: must be FLEET/ROBOT, not {shown:?}")
            })?;
            let (fleet, robot) = (Name::new(fleet).map_err(named)?, Name::robot(robot).map_err(named)?);
            fleets.entry(fleet).or_default().insert(robot);
        }
        Ok(Self(fleets.into_iter().map(|(fleet, robots)| (fleet, Arc::new(robots))).collect()))
    }

    /// The robots of a fleet; empty for a fleet that the file does not name.
    #[must_use]
    pub fn of_fleet(&self, fleet: &Name) -> Arc<HashSet<Name>> {
        self.0.get(fleet).cloned().unwrap_or_default()
    }
}

/// Identifies the version of a file, to notice changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stamp {
    modified: Option<SystemTime>,
    bytes: u64,
    #[cfg(unix)]
    inode: u64,
}

impl Stamp {
    fn of(metadata: &Metadata) -> Self {
        Self {
            modified: metadata.modified().ok(),
            bytes: metadata.len(),
            #[cfg(unix)]
            inode: std::os::unix::fs::MetadataExt::ino(metadata),
        }
    }
}

/// Reads the file, and again after each change, until `stop`. If it becomes invalid or disappears, the last valid list
/// stays in force.
///
/// # Errors
/// The file is invalid at the start.
pub(crate) fn follow(
    path: PathBuf,
    mut stop: watch::Receiver<bool>,
) -> Result<watch::Receiver<Arc<RobotsFile>>, String> {
    let (first, stamp) = RobotsFile::read_with_stamp(&path)?;
    let (sender, receiver) = watch::channel(Arc::new(first));
    task::spawn(async move {
        let (mut last, mut told) = (stamp, None);
        while timeout(LOOK_EVERY, stop.wait_for(|&stop| stop)).await.is_err() {
            let is_same = || std::fs::metadata(&path).is_ok_and(|metadata| Stamp::of(&metadata) == last);
            // After a problem it is read at each look: access rights change without the stamp.
            if told.is_none() && is_same() {
                continue;
            }
            match RobotsFile::read_with_stamp(&path) {
                Ok((file, read)) => {
                    (last, told) = (read, None);
                    info!(path = %path.display(), fleets = file.0.len(), "limits.robots_file reloaded");
                    sender.send_replace(Arc::new(file));
                }
                Err(problem) if told.as_ref() != Some(&problem) => {
                    warn!(problem, "limits.robots_file cannot be used, keeping the last list");
                    told = Some(problem);
                }
                Err(_) => {}
            }
        }
    });
    Ok(receiver)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_names_robots_by_fleet_with_comments() {
        let file = RobotsFile::parse("# the press\n\npress/r1\n  press/r2  # spare\nlab/r1\n").unwrap();
        let robots = |fleet: &str| {
            let mut names: Vec<String> =
                file.of_fleet(&Name::new(fleet).unwrap()).iter().map(ToString::to_string).collect();
            names.sort();
            names
        };
        assert_eq!(robots("press"), ["r1", "r2"]);
        assert_eq!(robots("lab"), ["r1"]);
        assert!(robots("other").is_empty());
    }

    #[test]
    fn a_line_that_is_wrong_is_named() {
        for (text, expected) in [
            ("a/b\nrobot", "line 2: must be FLEET/ROBOT, not \"robot\""),
            ("a/b\n\n\na/b/c", "line 4: \"b/c\" is not a valid name"),
            ("a/supervisor", "line 1: a robot cannot be named \"supervisor\""),
            ("/b", "line 1: \"\" is not a valid name"),
        ] {
            let problem = RobotsFile::parse(text).unwrap_err();
            assert!(problem.starts_with(expected), "{problem}");
        }
    }
}
