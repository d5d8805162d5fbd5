//! Shards of a fleet: who owns each, and their number.

use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{Json, Response};
use serde::{Deserialize, Serialize};
use serde_json::json;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::actions::RecordedKind;
use vibrissa_edge::shard::SHARDS_MAX;
use vibrissa_edge::words::Word as _;
use vibrissa_store::lists::actions::ActionRow;
use vibrissa_store::shards::{ShardSummary, ShardsSet};

use super::paths::FleetPath;
use crate::http::App;
use crate::http::asking::{Asker, answered, number_of, reason};
use crate::http::extract::{Body, Path};
use crate::http::problem::{Kind, Problem};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(get_shards, set_shards))
}

/// The shards of a fleet.
#[derive(Debug, Serialize, ToSchema)]
pub struct FleetShards {
    /// The shards in order of their numbers.
    pub items: Vec<ShardSummary>,
}

/// The number of shards that a fleet shall have.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ShardsBody {
    /// Number of shards: 1 for a fleet that is not divided.
    #[schema(minimum = 1, maximum = 1024)]
    pub shards: u32,
    /// Reason in free text, at most 1000 characters.
    #[schema(max_length = 1000)]
    pub reason: Option<String>,
}

/// The shards of a fleet, each with its owner, epoch and robots.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/shards", tag = "fleets", params(FleetPath),
    responses((status = 200, description = "The shards", body = FleetShards))
)]
async fn get_shards(State(app): State<App>, Path(at): Path<FleetPath>) -> Result<Json<FleetShards>, Problem> {
    let items = app.store.shards(&at.fleet).await?;
    if items.is_empty() { Err(Problem::not_found(&at)) } else { Ok(Json(FleetShards { items })) }
}

/// Change the number of shards of a fleet, up or down.
///
/// All owners release the fleet; one supervisor writes checkpoints of all robots and replaces the shards. This takes some
/// seconds, in which robots keep their contacts. A supervisor that starts with a higher `fleet.shards` raises the number again.
#[utoipa::path(
    put, path = "/v1/fleets/{fleet}/shards", tag = "fleets",
    params(FleetPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = ShardsBody,
    responses((status = 202, description = "Stated; the supervisors change it", body = ActionRow)),
    extensions(("x-required-role" = json!("ADMIN")))
)]
async fn set_shards(
    State(app): State<App>,
    Path(at): Path<FleetPath>,
    asker: Asker,
    Body(body): Body<ShardsBody>,
) -> Result<Response, Problem> {
    let ShardsBody { shards, reason: why } = body;
    if !(1..=SHARDS_MAX).contains(&shards) {
        return Err(Problem::invalid("shards", format!("must be from 1 to {SHARDS_MAX}")));
    }
    let mut action = asker.action(RecordedKind::Shards.word(), &json!({ "shards": shards }), reason(why)?);
    action.fleet = Some(at.fleet.to_string());
    match app.store.set_shards(&at.fleet, shards, &action).await? {
        ShardsSet::Done(asked) => answered(&app, number_of(*asked)?, StatusCode::ACCEPTED).await,
        ShardsSet::NoFleet => Err(Problem::not_found(&at)),
        ShardsSet::Refused(why) => {
            Err(Problem::new(Kind::Refused, format!("the number of shards of {at} cannot change: {why}")))
        }
    }
}
