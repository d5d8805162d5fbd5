//! Changes of the number of shards of a fleet, while it is supervised.
//!
//! All owners release the fleet. One supervisor then acquires all its shards, recovers each, and writes checkpoints of all
//! robots, so that no journal row of the old shards is needed any more. Then it replaces the leases. Meanwhile robots keep
//! the contacts that have no receipt, as at each change of owner.

use tracing::{error, info};
use vibrissa_protocol::BootId;
use vibrissa_store::shards::NotDivided;
use vibrissa_store::{Lease, LossCause, StoreError};

use crate::fleet::{Shared, engine_options};

/// Changes the number of a fleet's shards to `count`, under the leases of all its shards. Leases that still hold afterwards
/// are released.
pub(crate) async fn divide(held: Vec<Lease>, count: u32, shared: Shared) {
    let Some(fleet) = held.first().map(|lease| lease.fleet().clone()) else { return };
    let before = held.len();
    let mut writer = shared.store.writer();
    let outcome = match drained(&held, &shared).await {
        Ok(true) => writer.divide(&held, count).await,
        Ok(false) => Ok(Err(NotDivided::NotDrained)),
        Err(problem) => Err(problem),
    };
    let reason = match outcome {
        Ok(Ok(())) => return info!(%fleet, shards = count, before, "number of shards changed"),
        Ok(Err(reason)) => {
            error!(%fleet, shards = count, before, %reason, "cannot change the number of shards, it stays as it is");
            writer.keep_shards(&fleet).await.err()
        }
        Err(problem) => Some(problem),
    };
    if let Some(problem) = reason {
        error!(%fleet, %problem, "cannot change the number of shards, retrying");
    }
    for lease in &held {
        if let Err(problem) = writer.release(lease).await {
            error!(%fleet, %problem, "cannot release the lease, it will expire");
        }
    }
}

/// Writes checkpoints of all robots. Returns false if the database rejects some.
async fn drained(held: &[Lease], shared: &Shared) -> Result<bool, StoreError> {
    for lease in held {
        let lost = || StoreError::LeaseLost {
            fleet: lease.shard().to_string(),
            epoch: lease.epoch(),
            cause: LossCause::TakenOver,
        };
        let boot_id = BootId::new(&format!("{}-division", shared.supervisor)).map_err(|_| lost())?;
        let engine = engine_options(lease, &boot_id, shared, None).start().await?;
        if !engine.drain().await.map_err(|_| lost())? {
            return Ok(false);
        }
    }
    Ok(true)
}
