//! Warnings about files with secrets that others can read.

use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Directory of container secrets. The mode of such a file is set outside the container.
const MOUNTED: &str = "/run/secrets";

/// A warning if others can read or change a file with secrets. Files owned by root may be group-readable, because that
/// is how they are passed to a service under another user (PostgreSQL has the same rule for its keys).
#[must_use]
pub fn open_file(key: &str, path: &Path) -> Option<String> {
    let file = std::fs::metadata(path).ok()?;
    let group = if file.uid() == 0 { 0o020 } else { 0o060 };
    let mode = file.mode() & 0o777;
    let is_for_all = mode & 0o006 != 0;
    if !is_for_all && mode & group == 0 {
        return None;
    }
    let who = if is_for_all { "everyone on this machine" } else { "its group" };
    let can = if mode & 0o022 == 0 { "read" } else { "read or change" };
    let shown = path.display();
    let us = own_uid();
    let what_to_do = if path.canonicalize().is_ok_and(|path: PathBuf| path.starts_with(MOUNTED)) {
        format!("its mode comes from outside the container: there give the file to user {us} with mode 0400")
    } else if file.uid() == us {
        format!("chmod 600 {shown}")
    } else {
        format!("chown {us} {shown} && chmod 600 {shown}")
    };
    Some(format!("{key}: {who} can {can} {shown} (mode {mode:04o}): {what_to_do}"))
}

/// The user of this process.
#[must_use]
pub fn own_uid() -> u32 {
    rustix::process::geteuid().as_raw()
}
