//! The folder with the files of a run. A mark shows that the demo has made the files there and may replace them.

use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Context as _;

const MARK: &str = "vibrissa-demo";
const MARK_TEXT: &str = "The demo of vibrissa replaces its files in this folder at each start.\n";
const DATABASE: &str = "demo.sqlite3";
const PICTURE: &str = "demo.svg";
/// All files of a run, the one with the lock last.
const FILES: [&str; 5] = [DATABASE, "demo.sqlite3-wal", "demo.sqlite3-shm", PICTURE, "demo.sqlite3.lock"];

/// Creates the folder for this run's files, and removes those of an earlier run. Returns the paths of database and picture.
///
/// # Errors
/// The folder has such files without the mark of the demo, or cannot be written.
pub(super) fn fresh(folder: &Path) -> anyhow::Result<(PathBuf, PathBuf)> {
    std::fs::create_dir_all(folder).with_context(|| format!("creating the folder {}", folder.display()))?;
    let mark = folder.join(MARK);
    let is_ours = std::fs::symlink_metadata(&mark).is_ok_and(|found| found.is_file())
        && std::fs::read(&mark).is_ok_and(|text| text == MARK_TEXT.as_bytes());
    for file in FILES.map(|name| folder.join(name)) {
        if std::fs::symlink_metadata(&file).is_err() {
            continue;
        }
        if !is_ours {
            anyhow::bail!("{} exists, and no demo has left it: name another folder", file.display());
        }
        std::fs::remove_file(&file).with_context(|| format!("removing the old {}", file.display()))?;
    }
    if !is_ours {
        let written = File::create_new(&mark).and_then(|mut file| file.write_all(MARK_TEXT.as_bytes()));
        written.with_context(|| format!("creating {}", mark.display()))?;
    }
    Ok((folder.join(DATABASE), folder.join(PICTURE)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_files_that_no_demo_has_left_stay() {
        let folder = std::env::temp_dir().join(format!("vibrissa-demo-{}", std::process::id()));
        let (database, picture) = fresh(&folder).unwrap();
        std::fs::write(&database, "a database").unwrap();
        std::fs::write(&picture, "a picture").unwrap();
        fresh(&folder).unwrap();
        assert!(!database.exists() && !picture.exists());
        std::fs::remove_file(folder.join(MARK)).unwrap();
        for name in FILES {
            let file = folder.join(name);
            std::fs::write(&file, "keep me").unwrap();
            let refused = fresh(&folder).unwrap_err().to_string();
            assert!(refused.contains("no demo has left it"), "{refused}");
            assert_eq!(std::fs::read(&file).unwrap(), b"keep me");
            std::fs::remove_file(&file).unwrap();
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
