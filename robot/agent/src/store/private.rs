//! Files of the agent alone: with mode 0600, reached by no link, and owned by the agent's user.

use std::fs::{File, OpenOptions, Permissions};
use std::io::{Error, Read as _, Result};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt, fchown};
use std::path::Path;

use rustix::fs::OFlags;

use vibrissa_program::files::own_uid;

const MODE: u32 = 0o600;
/// Bytes by which a file is recognised.
const HEAD_BYTES: u64 = 64;

fn options() -> OpenOptions {
    // O_NONBLOCK keeps `open` from waiting for the other end of a named pipe.
    let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK;
    let mut options = OpenOptions::new();
    options.mode(MODE).custom_flags(flags.bits().cast_signed());
    options
}

/// Refuses a file that is not ours.
fn owned(file: File) -> Result<File> {
    let found = file.metadata()?;
    if !found.is_file() {
        return Err(Error::other("it is no regular file"));
    }
    if found.uid() != own_uid() && own_uid() != 0 {
        return Err(Error::other(format!("it belongs to user {}", found.uid())));
    }
    Ok(file)
}

/// Refuses a file that is not only ours.
fn checked(file: File) -> Result<File> {
    let file = owned(file)?;
    if file.metadata()?.nlink() > 1 {
        return Err(Error::other("it has another name, too (a hard link)"));
    }
    Ok(file)
}

/// Closes a file to others. Call it only once the content shows that the agent has written the file.
pub(super) fn close_to_others(file: &File) -> Result<()> {
    if file.metadata()?.mode() & 0o077 == 0 { Ok(()) } else { file.set_permissions(Permissions::from_mode(MODE)) }
}

/// Gives a new file of root to the owner of its folder: a calibration as root, before the first start, would keep the service's
/// user from its own lock.
pub(super) fn give_to_owner(file: &File, path: &Path) -> Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (found, owner) = (file.metadata()?, std::fs::metadata(folder)?);
    if own_uid() == 0 && found.uid() == 0 && owner.uid() != 0 {
        fchown(file, Some(owner.uid()), Some(owner.gid()))?;
    }
    Ok(())
}

fn explained(opened: Result<File>) -> Result<File> {
    let is_link = |problem: &Error| problem.raw_os_error() == Some(rustix::io::Errno::LOOP.raw_os_error());
    opened.map_err(|problem| if is_link(&problem) { Error::other("it is a symbolic link") } else { problem })
}

/// Opens a file to read it.
pub(super) fn read(path: &Path) -> Result<File> {
    checked(explained(options().read(true).open(path))?)
}

/// Opens a file that is only read, whatever other names it has: a backup may consist of links.
pub(super) fn read_linked(path: &Path) -> Result<File> {
    owned(explained(options().read(true).open(path))?)
}

/// Opens a file to append to it; it is created if it is missing.
pub(super) fn append(path: &Path) -> Result<File> {
    checked(explained(options().append(true).create(true).open(path))?)
}

/// Creates a file that does not exist yet.
pub(super) fn create(path: &Path) -> Result<File> {
    options().write(true).create_new(true).open(path)
}

/// Creates a file anew, in place of one that the agent has left: `is_ours` recognises its first bytes.
pub(super) fn anew(path: &Path, is_ours: impl Fn(&[u8]) -> bool) -> Result<File> {
    match read(path) {
        Ok(file) => {
            let mut head = Vec::new();
            file.take(HEAD_BYTES).read_to_end(&mut head)?;
            if !is_ours(&head) {
                return Err(Error::other("the agent has not written it: move it away"));
            }
            std::fs::remove_file(path)?;
        }
        Err(problem) if problem.kind() == std::io::ErrorKind::NotFound => {}
        Err(problem) => return Err(problem),
    }
    create(path)
}
