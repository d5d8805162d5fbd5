//! The database's address, and its password from a file.

use std::path::PathBuf;

use url::Url;

use super::keys::Key;
use super::problem::Origin;
use super::reader::{MASK, Reader};
use vibrissa_store::{DatabaseAddress, address};

/// Reads the database's address.
pub(super) fn database(reader: &mut Reader) -> Option<DatabaseAddress> {
    let url = reader.text(Key::DatabaseUrl);
    let filed = reader.secret_file(Key::DatabasePasswordFile);
    let is_filed = reader.is_explicit(Key::DatabasePasswordFile);
    let written = url.as_deref().and_then(password);
    if written.as_deref() == Some(MASK) {
        let what = format!(
            "{MASK} is only the mask of a hidden password: write the password itself, or leave it out \
                            and set database.password_file"
        );
        reader.refuse(Key::DatabaseUrl, what);
        return None;
    }
    if written.is_some() {
        if let Origin::Flag(_) = reader.origin(Key::DatabaseUrl) {
            let what = format!(
                "holds a password, and everyone on this machine can read the command line (ps): leave it out and set \
                 database.password_file (--{} FILE), or write the whole URL into the environment variable {}",
                Key::DatabasePasswordFile.flag(),
                Key::DatabaseUrl.environment()
            );
            reader.refuse(Key::DatabaseUrl, what);
            return None;
        }
        reader.holds_secret(Key::DatabaseUrl);
    }
    if let Some(key_file) = url.as_deref().and_then(private_key) {
        reader.secret_files.push((Key::DatabaseUrl, key_file));
    }
    if written.is_some() && is_filed {
        reader.refuse(Key::DatabasePasswordFile, "database.url holds a password too: leave one of them out");
    }
    match reader.parsed(Key::DatabaseUrl, str::parse::<DatabaseAddress>)? {
        DatabaseAddress::Sqlite(path) => {
            if is_filed {
                let what = "has no effect with SQLite: leave it out, or set database.url to postgres://...";
                reader.refuse(Key::DatabasePasswordFile, what);
            }
            Some(DatabaseAddress::Sqlite(path))
        }
        DatabaseAddress::Postgres(address) => Some(DatabaseAddress::Postgres(match filed {
            Some(password) => address.with_password(password),
            None => address,
        })),
    }
}

/// The URL of PostgreSQL servers, with the first one alone.
fn server_url(text: &str) -> Option<Url> {
    address::url_of_first(text).filter(|url| url.scheme() != "sqlite")
}

/// The password in a database URL, in either place that libpq allows.
fn password(text: &str) -> Option<String> {
    let url = server_url(text)?;
    let asked = url.query_pairs().find(|(name, _)| name == "password").map(|(_, value)| value.into_owned());
    url.password().map(str::to_owned).or(asked)
}

/// The file with the client's private key that a database URL names.
fn private_key(text: &str) -> Option<PathBuf> {
    let url = server_url(text)?;
    let key = url.query_pairs().find(|(name, _)| matches!(&**name, "sslkey" | "ssl-key"));
    key.map(|(_, file)| PathBuf::from(file.into_owned()))
}

/// A valid database URL with its password masked.
pub(super) fn masked(text: &str) -> String {
    let Some(mut url) = address::url_of_first(text) else { return text.to_owned() };
    if password(text).is_none() {
        return text.to_owned();
    }
    if url.password().is_some() && url.set_password(Some(MASK)).is_err() {
        return MASK.to_owned();
    }
    if url.query().is_some() {
        let mask = |(name, value): (std::borrow::Cow<'_, str>, std::borrow::Cow<'_, str>)| {
            let value = if name == "password" { MASK.to_owned() } else { value.into_owned() };
            (name.into_owned(), value)
        };
        let pairs: Vec<(String, String)> = url.query_pairs().map(mask).collect();
        url.query_pairs_mut().clear().extend_pairs(pairs);
    }
    address::with_hosts_of(&url, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_place_of_a_url_shows_its_password() {
        for (text, shown) in [
            ("sqlite:a b.sqlite3", "sqlite:a b.sqlite3"),
            ("postgres://u@h/d", "postgres://u@h/d"),
            ("postgres://u:hunter2@h/d", "postgres://u:***@h/d"),
            ("postgres://u@h/d?password=hunter2&sslmode=require", "postgres://u@h/d?password=***&sslmode=require"),
            ("postgres://u:hunter2@h:1,i:2/d", "postgres://u:***@h:1,i:2/d"),
            ("postgres://u@h,i/d?password=hunter2", "postgres://u@h,i/d?password=***"),
            ("postgres://u:hunter2@h/d?password=hunter2", "postgres://u:***@h/d?password=***"),
        ] {
            assert_eq!(masked(text), shown);
        }
    }
}
