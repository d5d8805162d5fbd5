//! A Parquet file that is being written to the object store.

use object_store::buffered::BufWriter;
use tokio::io::AsyncWriteExt as _;
use tracing::warn;
use vibrissa_store::archive::Archived;
use vibrissa_store::export::{Cell, ExportColumn};

use super::object::{Objects, Piece};
use crate::parquet_rows::ParquetRows;

/// Bytes of the writer that are sent together, at least.
const PIECE_BYTES: usize = 64 * 1024;

/// The file, which exists only when it is complete.
pub(super) struct File {
    path: String,
    object: BufWriter,
    piece: Piece,
    rows: ParquetRows<Piece>,
    written: Archived,
}

impl File {
    pub(super) fn begin(objects: &Objects, path: String, columns: &'static [ExportColumn]) -> anyhow::Result<Self> {
        let (object, piece) = (objects.writer(&path)?, Piece::default());
        let rows = ParquetRows::begin(piece.clone(), "contacts", columns)?;
        Ok(Self { path, object, piece, rows, written: Archived::default() })
    }

    /// Adds a contact.
    pub(super) async fn push(&mut self, cells: Vec<Cell>) -> anyhow::Result<()> {
        self.written.contacts += 1;
        self.rows.push(cells)?;
        self.send(PIECE_BYTES).await
    }

    /// Number of contacts.
    pub(super) fn contacts(&self) -> u64 {
        self.written.contacts
    }

    /// Writes the end. From then on the file exists, and survives a loss of power.
    pub(super) async fn complete(mut self, objects: &Objects) -> anyhow::Result<Archived> {
        self.rows.finish()?;
        let rest = self.piece.take();
        self.written.bytes += rest.len() as u64;
        self.object.write_all(&rest).await?;
        self.object.shutdown().await?;
        objects.settle(&self.path).await?;
        Ok(self.written)
    }

    /// Removes the parts that are at the object store already. One that fails leaves them to a rule of the bucket.
    pub(super) async fn abort(mut self) {
        if let Err(problem) = self.object.abort().await {
            warn!(path = self.path, %problem, "cannot abort an incomplete upload to the archive");
        }
    }

    /// Sends what the writer has produced, if that is so much.
    async fn send(&mut self, least: usize) -> anyhow::Result<()> {
        if self.piece.len() < least {
            return Ok(());
        }
        let bytes = self.piece.take();
        self.written.bytes += bytes.len() as u64;
        self.object.write_all(&bytes).await?;
        Ok(())
    }
}
