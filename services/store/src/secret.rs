//! Passwords. `Debug` hides them, and a password from a file can be read again.

use std::io::Read;
use std::path::{Path, PathBuf};

/// Length of the longest accepted password file, bytes: a longer one is probably a wrong file.
const FILE_MAX_BYTES: u64 = 4096;

/// A password. No log, error or `Debug` output shows it.
#[derive(Clone)]
pub struct Secret {
    text: String,
    /// File that the password was read from, if any.
    file: Option<PathBuf>,
}

impl PartialEq for Secret {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

impl Eq for Secret {}

impl Secret {
    /// A password that does not come from a file.
    #[must_use]
    pub fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), file: None }
    }

    /// Reads a password from a file with a single line.
    ///
    /// # Errors
    /// The file cannot be read, or contains anything else. The error names the file and shows none of its content.
    pub fn from_file(path: &Path) -> Result<Self, String> {
        let fail = |what: &str| Err(format!("the file {} {what}", path.display()));
        let mut text = String::new();
        let read = std::fs::File::open(path).and_then(|file| file.take(FILE_MAX_BYTES + 1).read_to_string(&mut text));
        if let Err(problem) = read {
            return fail(&format!("cannot be read: {problem}"));
        }
        if text.len() as u64 > FILE_MAX_BYTES {
            return fail(&format!("is longer than {FILE_MAX_BYTES} bytes: name a file that contains a password only"));
        }
        let secret = text.trim_end_matches(['\r', '\n']);
        if secret.is_empty() || secret.contains(char::is_control) {
            return fail("must contain the password on one line and nothing else");
        }
        Ok(Self { text: secret.to_owned(), file: Some(path.to_owned()) })
    }

    /// The password with the present content of its file; unchanged if it came from no file.
    ///
    /// # Errors
    /// As [`Self::from_file`].
    pub fn read_again(&self) -> Result<Self, String> {
        self.file.as_deref().map_or_else(|| Ok(self.clone()), Self::from_file)
    }

    /// The password, for the code that authenticates with it.
    #[must_use]
    pub fn reveal(&self) -> &str {
        &self.text
    }
}

impl std::fmt::Debug for Secret {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("***")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_secret_of_a_file_follows_the_file_and_its_errors_do_not_show_it() {
        let path = std::env::temp_dir().join(format!("vibrissa-secret-{}", uuid::Uuid::new_v4()));
        std::fs::write(&path, "first\n").unwrap();
        let secret = Secret::from_file(&path).unwrap();
        std::fs::write(&path, "second").unwrap();
        let renewed = secret.read_again().unwrap();
        std::fs::write(&path, "two\nlines").unwrap();
        let refused = renewed.read_again().unwrap_err();
        std::fs::remove_file(&path).unwrap();
        assert_eq!((secret.reveal(), renewed.reveal()), ("first", "second"));
        assert!(refused.contains("vibrissa-secret-") && !refused.contains("two"), "{refused}");
        assert!(renewed.read_again().unwrap_err().contains("cannot be read"));
        assert_eq!(Secret::new("fixed").read_again().unwrap().reveal(), "fixed");
        assert_eq!(format!("{secret:?}"), "***");
    }
}
