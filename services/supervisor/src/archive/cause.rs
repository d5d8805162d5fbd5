//! Why contacts cannot be archived, with what to do: the errors of `object_store`.

use object_store::Error;
use vibrissa_protocol::plain;

/// The problem and its causes. The last one known is the last one told: behind it are only the words of libraries.
pub(super) fn cause(problem: &anyhow::Error) -> String {
    let mut story = Vec::new();
    for cause in problem.chain() {
        if let Some(problem) = cause.downcast_ref::<Error>() {
            story.push(of_store(problem));
            break;
        }
        story.push(plain::text(&cause.to_string()));
        if cause.is::<vibrissa_store::StoreError>() {
            break;
        }
    }
    story.join(": ")
}

fn of_store(problem: &Error) -> String {
    let refused = "let this user read, write and list there, or correct archive.s3_access_key and its secret";
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: classified by their texts")]
    match problem {
        Error::PermissionDenied { path, .. } => format!("{path} may not be used: {refused}"),
        Error::Unauthenticated { path, .. } => format!("the keys are not accepted at {path}: {refused}"),
        Error::NotFound { path, .. } => format!("{path} does not exist: create the bucket, or correct archive.url"),
        Error::AlreadyExists { path, .. } => {
            format!("{path} exists already: move it away, it is not this program's file")
        }
        Error::InvalidPath { .. } => "the path cannot be used: correct archive.url".to_owned(),
        other => of_text(&other.to_string()),
    }
}

/// The library tells these only in the text of a generic error.
fn of_text(text: &str) -> String {
    let has = |parts: &[&str]| parts.iter().any(|part| text.contains(part));
    let remedy = if has(&["os error 28", "No space left"]) {
        "the disk is full: free space"
    } else if has(&["os error 13", "os error 30", "Permission denied", "Read-only file system"]) {
        "the folder cannot be written: give this user the right, or mount the disk for writing"
    } else if has(&["NoSuchBucket"]) {
        "the bucket does not exist: create it, or correct archive.url"
    } else if has(&["status code: 403", "403 Forbidden", "InvalidAccessKeyId", "SignatureDoesNotMatch"]) {
        "the keys are not accepted: correct the access key, its secret and the region, or this host's clock"
    } else if has(&["onnection refused"]) {
        "nothing listens there: start the store, or correct its endpoint"
    } else if has(&["dns error", "lookup address"]) {
        "no address is known for the store: correct its endpoint, or DNS"
    } else if has(&["timed out", "timeout"]) {
        "no answer in time: check the endpoint, the network and firewalls"
    } else {
        return plain::text(text);
    };
    remedy.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_each_cause_has_a_remedy_and_no_words_of_the_library() {
        let generic = |text: &str| Error::Generic { store: "S3", source: text.into() };
        let denied = Error::PermissionDenied { path: "a/b".to_owned(), source: "<Error>".into() };
        for (problem, part) in [
            (denied, "a/b may not be used"),
            (generic("Server returned non-2xx status code: 403 Forbidden: <Error>"), "access key"),
            (generic("error sending request: Connection refused (os error 111)"), "nothing listens"),
            (generic("Unable to open file: No space left on device (os error 28)"), "free space"),
        ] {
            let shown = cause(&anyhow::Error::new(problem).context("writing x"));
            assert!(shown.starts_with("writing x: ") && shown.contains(part), "{shown}");
            assert!(!shown.contains("os error") && !shown.contains("Generic") && !shown.contains("<Error>"), "{shown}");
        }
    }
}
