//! The object store: a local folder or S3.

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context, bail};
use object_store::aws::AmazonS3Builder;
use object_store::buffered::BufWriter;
use object_store::local::LocalFileSystem;
use object_store::path::Path;
use object_store::{BackoffConfig, ObjectStore, RetryConfig};
use url::Url;
use vibrissa_host::task;
use vibrissa_store::secret::Secret;

use crate::archive_options::{ArchiveOptions, S3Options};
use std::time::Duration;

/// Size up to which an object is sent at once, and of the parts of larger ones, bytes. S3 allows 10,000 parts.
const PART_BYTES: usize = 8 * 1024 * 1024;
/// Time limit for the client's own attempts of one request. The archive tries again later.
const RETRY_TIME: Duration = Duration::from_secs(20);

/// An object store, and the folder of the archive there.
#[derive(Debug)]
pub(super) struct Objects {
    store: Arc<dyn ObjectStore>,
    prefix: Path,
    /// The local folder, if it is one.
    folder: Option<PathBuf>,
}

impl Objects {
    pub(super) fn open(options: &ArchiveOptions) -> anyhow::Result<Self> {
        let url = Url::parse(&options.url).with_context(|| format!("{} is not a URL", options.url))?;
        match url.scheme() {
            "file" => {
                let folder = url.to_file_path().ok().context("write file:///FOLDER, with the folder's full path")?;
                std::fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
                let store = Arc::new(LocalFileSystem::new_with_prefix(&folder)?);
                Ok(Self { store, prefix: Path::default(), folder: Some(folder) })
            }
            "s3" => {
                let bucket = url.host_str().context("write s3://BUCKET/PREFIX")?;
                let prefix = Path::from_url_path(url.path())?;
                Ok(Self { store: Arc::new(s3(bucket, &options.s3)?), prefix, folder: None })
            }
            scheme => bail!("{scheme}:// is not supported: write file:///FOLDER or s3://BUCKET/PREFIX"),
        }
    }

    /// Begins an object, which exists only when the writer is shut down.
    pub(super) fn writer(&self, path: &str) -> anyhow::Result<BufWriter> {
        let path = self.prefix.parts().chain(Path::parse(path)?.parts()).collect();
        Ok(BufWriter::with_capacity(self.store.clone(), path, PART_BYTES))
    }

    /// Waits until a written object survives a loss of power: S3 has ensured it, a folder has not.
    pub(super) async fn settle(&self, path: &str) -> anyhow::Result<()> {
        let Some(folder) = &self.folder else { return Ok(()) };
        let file = folder.join(path);
        let sync = move || {
            std::fs::File::open(&file)?.sync_all()?;
            file.ancestors().skip(1).take(3).try_for_each(|folder| std::fs::File::open(folder)?.sync_all())
        };
        task::blocking(sync).await?.with_context(|| format!("cannot sync {path}"))
    }
}

fn s3(bucket: &str, options: &S3Options) -> anyhow::Result<object_store::aws::AmazonS3> {
    // The HTTP client takes the process's cryptography. An error means that the same one is installed already.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let backoff = BackoffConfig::default();
    let retry = RetryConfig { backoff, max_retries: 5, retry_timeout: RETRY_TIME };
    let mut builder = AmazonS3Builder::from_env().with_bucket_name(bucket).with_retry(retry);
    if let Some(endpoint) = &options.endpoint {
        builder = builder.with_endpoint(endpoint).with_allow_http(endpoint.starts_with("http://"));
    }
    if let Some(region) = &options.region {
        builder = builder.with_region(region);
    }
    if let Some(access_key) = &options.access_key {
        builder = builder.with_access_key_id(access_key);
    }
    if let Some(file) = &options.secret_key_file {
        let secret = Secret::from_file(file).map_err(anyhow::Error::msg)?;
        builder = builder.with_secret_access_key(secret.reveal().trim());
    }
    Ok(builder.build()?)
}

/// Bytes that a Parquet writer has produced and that are not sent yet. Clones share them.
#[derive(Debug, Clone, Default)]
pub(super) struct Piece(Arc<Mutex<Vec<u8>>>);

impl Piece {
    /// Number of bytes.
    pub(super) fn len(&self) -> usize {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// Removes and returns the bytes.
    pub(super) fn take(&self) -> Vec<u8> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Write for Piece {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
