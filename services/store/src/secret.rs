//! Passwords. `Debug` hides them, and a password from a file can be read again.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use vibrissa_protocol::plain;
use vibrissa_protocol::text_file::read_text;

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
        let text = match read_text(path, FILE_MAX_BYTES) {
            Ok(text) => text,
            Err(problem) if problem.kind() == ErrorKind::FileTooLarge => {
                let what = format!("is longer than {FILE_MAX_BYTES} bytes: name a file that contains a password only");
                return fail(&what);
            }
            Err(problem) => return fail(&format!("cannot be read: {}", plain::io(&problem))),
        };
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
        let path = std::env::temp_dir().join(format!("vibrissa-secret-{}", vibrissa_host::random::hex()));
        std::fs::write(&path, "first\n").unwrap();
        let secret = Secret::from_file(&path).unwrap();
        std::fs::write(&path, "second").unwrap();
        let renewed = secret.read_again().unwrap();
        for bytes in ["\u{feff}second\r\n".as_bytes(), b"\xff\xfes\0e\0c\0o\0n\0d\0\r\0\n\0"] {
            std::fs::write(&path, bytes).unwrap();
            assert_eq!(secret.read_again().unwrap().reveal(), "second", "a byte order mark is no part of a password");
        }
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
