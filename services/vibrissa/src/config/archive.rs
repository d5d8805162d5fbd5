//! The archive of contacts.

use std::time::Duration;

use super::keys::Key;
use super::reader::Reader;
use vibrissa_supervisor::archive_options::{ArchiveOptions, S3Options};
use vibrissa_supervisor::engine::ContactRetention;

/// The archive, if configured; outer `None` after a refusal. `keep` is what the database stores.
#[expect(clippy::option_option, reason = "outer: None after a refusal; inner: None if not configured")]
pub(super) fn archive(reader: &mut Reader, keep: Option<ContactRetention>) -> Option<Option<ArchiveOptions>> {
    let is_set = reader.is_explicit(Key::ArchiveUrl);
    let url = reader.parsed(Key::ArchiveUrl, location);
    let every_s = reader.whole(Key::ArchiveEveryS)?;
    let endpoint = reader.parsed(Key::ArchiveS3Endpoint, server);
    let (region, access_key) = (reader.text(Key::ArchiveS3Region), reader.text(Key::ArchiveS3AccessKey));
    let secret_key_file = reader.private_file(Key::ArchiveS3SecretKeyFile);
    if !is_set {
        return Some(None);
    }
    if !cfg!(feature = "archive") {
        let what = "this program was built without the archive: build it with --features archive, or leave the key out";
        reader.refuse(Key::ArchiveUrl, what);
        return None;
    }
    if keep.is_some_and(|keep| keep != ContactRetention::All) {
        let what = "needs contacts.keep = \"all\": contacts are archived from the database. A connector archives Kafka's topic";
        reader.refuse(Key::ArchiveUrl, what);
        return None;
    }
    if access_key.is_some() != secret_key_file.is_some() {
        reader.refuse(Key::ArchiveS3AccessKey, "needs archive.s3_secret_key_file, and the other way round");
        return None;
    }
    let s3 = S3Options { endpoint, region, access_key, secret_key_file };
    Some(Some(ArchiveOptions { url: url?, every: Duration::from_secs(every_s.into()), s3 }))
}

fn location(text: &str) -> Result<String, String> {
    let example = "write file:///FOLDER or s3://BUCKET/PREFIX";
    let url = url::Url::parse(text).map_err(|problem| format!("is not a URL ({problem}): {example}"))?;
    let is_valid = match url.scheme() {
        "file" => url.host_str().is_none() && url.path().len() > 1,
        "s3" => url.host_str().is_some_and(|bucket| !bucket.is_empty()),
        _ => false,
    };
    if !is_valid || url.query().is_some() || url.fragment().is_some() {
        return Err(format!("is not a folder or a bucket: {example}"));
    }
    if !url.username().is_empty() || url.password().is_some() {
        return Err("must not hold keys: use archive.s3_access_key and archive.s3_secret_key_file".to_owned());
    }
    Ok(url.into())
}

fn server(text: &str) -> Result<String, String> {
    let url = super::address::web_url(text).map_err(|problem| format!("{problem}: write https://HOST"))?;
    match url.scheme() {
        "http" | "https" if url.username().is_empty() && url.password().is_none() => Ok(text.to_owned()),
        _ => Err("must begin with https:// or http://, without a password".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_location_is_a_folder_or_a_bucket() {
        for good in ["file:///var/lib/vibrissa/archive", "s3://bucket", "s3://bucket/a/b"] {
            assert_eq!(location(good).as_deref(), Ok(good));
        }
        for bad in ["archive", "/var/lib", "file://host/x", "file:///", "https://bucket", "s3:bucket", "s3://b?x=1"] {
            assert!(location(bad).unwrap_err().contains("write file:///FOLDER"), "{bad}");
        }
        assert!(location("s3://key:secret@bucket").unwrap_err().contains("must not hold keys"));
    }
}
