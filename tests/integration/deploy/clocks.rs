//! The wall clock is for stamps and expiry alone. A duration that is measured with it is wrong whenever somebody sets it.

use std::collections::BTreeMap;
use std::fs::{read_dir, read_to_string};
use std::path::Path;

use crate::project;

/// Folders with code, and documents with examples that people copy.
const PLACES: [&str; 7] = ["services", "robot", "lab", "tests", "python", "dashboards", "docs"];
/// Endings of the files that are searched, each with the words that read the wall clock.
const WORDS: [(&[&str], &[&str]); 3] = [
    (
        &["rs"],
        &["SystemTime::now", "UNIX_EPOCH.elapsed", "Utc::now", "Local::now", "now_utc(", "now_local(", "Realtime"],
    ),
    (
        &["py", "pyi", "md", "ipynb"],
        &["time.time(", "time.time_ns(", "datetime.now(", "utcnow(", "from time import", ".today("],
    ),
    (
        &["ino", "c", "cpp", "h", "hpp"],
        &["gettimeofday", "CLOCK_REALTIME", "system_clock", "time(NULL)", "time(0)", "time(nullptr)"],
    ),
];
/// Every place that reads the wall clock: how often, and for what.
const ALLOWED: [(&str, usize, &str); 6] = [
    ("services/host/src/clock.rs", 1, "the time line of a process begins with it; stamps of an agent follow it slowly"),
    ("tests/src/kafka/clients.rs", 1, "stamp of a record"),
    ("tests/integration/kafka/model.rs", 1, "stamp of a record"),
    ("tests/integration/ros2/peer.py", 1, "stamp of a header"),
    ("docs/webhooks.md", 1, "age of a signature by its stamp"),
    ("docs/robot-quickstart.md", 1, "the robot's time line begins with it"),
];

fn search(folder: &Path, found: &mut BTreeMap<String, usize>) {
    for entry in read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        if path.is_dir() {
            if !["target", "node_modules", ".venv", "build"].contains(&name) {
                search(&path, found);
            }
            continue;
        }
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let words = WORDS.iter().find(|(endings, _)| endings.contains(&ending)).map_or(&[][..], |(_, words)| *words);
        if words.is_empty() || path.ends_with("deploy/clocks.rs") {
            continue;
        }
        let text = read_to_string(&path).unwrap();
        let count = words.iter().map(|word| text.matches(word).count()).sum();
        if count > 0 {
            let path = path.strip_prefix(project()).unwrap();
            found.insert(path.to_str().unwrap().to_owned(), count);
        }
    }
}

#[test]
fn no_duration_is_measured_with_the_wall_clock() {
    let mut found = BTreeMap::new();
    PLACES.iter().map(|place| project().join(place)).filter(|path| path.is_dir()).for_each(|path| {
        search(&path, &mut found);
    });
    let allowed = ALLOWED.iter().map(|(path, count, _)| ((*path).to_owned(), *count)).collect();
    assert_eq!(
        found, allowed,
        "the wall clock is for stamps and expiry: measure durations with Instant, time.monotonic(), micros() or \
         clock_gettime(CLOCK_MONOTONIC), and name a new stamp here with its reason"
    );
}
