//! Settings of the archive.

use std::path::PathBuf;
use std::time::Duration;

/// Where the contacts are archived.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ArchiveOptions {
    /// `file:///folder`, or `s3://bucket/prefix`.
    pub url: String,
    /// Time of receipt that a file covers.
    pub every: Duration,
    /// Access to S3.
    pub s3: S3Options,
}

/// Access to an S3 server. Without keys, the usual environment variables of AWS are used.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct S3Options {
    /// URL of the server; `None` for AWS.
    pub endpoint: Option<String>,
    /// Region of the bucket.
    pub region: Option<String>,
    /// Identifier of the access key.
    pub access_key: Option<String>,
    /// File with the secret of the access key.
    pub secret_key_file: Option<PathBuf>,
}
