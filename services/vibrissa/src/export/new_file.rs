//! A new file that exists under its name only when it is complete.

use std::fs::{self, File};
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

/// A file under a temporary name. Unless it is completed, it is removed when this value is dropped.
#[derive(Debug)]
pub struct NewFile {
    /// `None` once the file is complete.
    file: Option<BufWriter<File>>,
    /// Temporary name.
    partial: PathBuf,
    /// Name of the complete file.
    path: PathBuf,
}

impl NewFile {
    /// Creates the file under a temporary name in the folder of `path`.
    ///
    /// # Errors
    /// A file of that name exists, or its folder cannot be written.
    pub fn create(path: &Path) -> anyhow::Result<Self> {
        if path.exists() {
            bail!("{} exists already: choose another name, or remove it", path.display());
        }
        let name = path.file_name().with_context(|| format!("{} names no file: add a name", path.display()))?;
        let mut partial_name = name.to_owned();
        partial_name.push(format!(".{}.partial", std::process::id()));
        let partial = path.with_file_name(partial_name);
        let file = File::create_new(&partial).with_context(|| format!("cannot create {}", partial.display()))?;
        Ok(Self { file: Some(BufWriter::new(file)), partial, path: path.to_owned() })
    }

    fn file(&mut self) -> io::Result<&mut BufWriter<File>> {
        self.file.as_mut().ok_or_else(|| io::Error::other("the file is complete"))
    }

    /// Gives the file its name after all of its content is on the disk.
    ///
    /// # Errors
    /// The file cannot be written, or a file of that name was created meanwhile.
    pub fn complete(mut self) -> anyhow::Result<()> {
        let failed = || format!("cannot write {}", self.path.display());
        let file = self.file.take().context("the file is complete")?;
        let file = file.into_inner().map_err(|problem| problem.into_error()).with_context(failed)?;
        file.sync_all().with_context(failed)?;
        name(&self.partial, &self.path, fs::hard_link(&self.partial, &self.path)).with_context(failed)
    }
}

/// Gives a file its name, if the attempt to `link` it failed for want of hard links, as on FAT. Unlike a renaming, neither a link
/// nor a new file ever replaces another file.
fn name(partial: &Path, path: &Path, link: io::Result<()>) -> io::Result<()> {
    match link {
        Err(problem) if problem.kind() != io::ErrorKind::AlreadyExists => {
            File::create_new(path)?;
            fs::rename(partial, path)
        }
        linked => linked,
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file()?.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file()?.flush()
    }
}

impl Seek for NewFile {
    fn seek(&mut self, position: io::SeekFrom) -> io::Result<u64> {
        self.file()?.seek(position)
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        // The temporary name is of no use, whether the file is complete or not.
        let _ = fs::remove_file(&self.partial);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_has_its_name_only_when_it_is_complete_and_replaces_none() {
        let folder = std::env::temp_dir().join(format!("vibrissa-new-file-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("rows.csv");
        let names = || fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect::<Vec<_>>();
        let mut abandoned = NewFile::create(&path).unwrap();
        abandoned.write_all(b"half").unwrap();
        assert!(!path.exists());
        drop(abandoned);
        assert!(names().is_empty());
        let mut file = NewFile::create(&path).unwrap();
        file.write_all(b"whole").unwrap();
        file.complete().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert_eq!(names(), ["rows.csv"]);
        assert!(NewFile::create(&path).unwrap_err().to_string().contains("exists already"));

        // A file system without hard links.
        let (partial, other) = (folder.join("partial"), folder.join("other.csv"));
        let no_links = || Err(io::ErrorKind::PermissionDenied.into());
        fs::write(&partial, b"more").unwrap();
        assert_eq!(name(&partial, &path, no_links()).unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        name(&partial, &other, no_links()).unwrap();
        assert_eq!((fs::read(&other).unwrap(), fs::read(&path).unwrap()), (b"more".to_vec(), b"whole".to_vec()));
        assert!(!partial.exists());
        fs::remove_dir_all(&folder).unwrap();
    }
}
