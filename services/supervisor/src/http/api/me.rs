//! The caller: name, role, fleets, and how the service knows them.

use axum::extract::Extension;
use axum::response::Json;
use serde::Serialize;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::http::App;
use crate::http::access::{Authentication, Caller, Role, Scope};
use vibrissa_store::time::Time;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(get_me))
}

/// 10000-01-01, µs since 1970 UTC. RFC 3339 cannot express it or a later time.
const YEAR_10000_US: i64 = 253_402_300_800_000_000;

/// The caller of a request.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Me {
    /// Name for people: that of the token, or of the person by the identity provider.
    pub name: String,
    /// Name in the audit log: `token:NAME#ID`, `oidc:NAME#SUBJECT`, `token_file`, or `local`.
    pub actor: String,
    /// Role of the caller. `x-required-role` of each operation in `/openapi.json` says which role it requires.
    pub role: Role,
    /// Fleets that the caller may access, as names and patterns in order; null for all fleets.
    pub fleets: Option<Vec<String>>,
    /// How the caller was authenticated.
    pub authentication: Authentication,
    /// Expiry of the token; null if it has none before the year 10000.
    pub expires_at: Option<Time>,
}

impl From<Caller> for Me {
    fn from(caller: Caller) -> Self {
        let fleets = match caller.scope {
            Scope::All => None,
            Scope::Only(fleets) => Some(fleets.iter().map(ToString::to_string).collect()),
        };
        Self {
            name: caller.name,
            actor: caller.actor,
            role: caller.role,
            fleets,
            authentication: caller.authentication,
            expires_at: caller.expires_us.filter(|&expires_us| expires_us < YEAR_10000_US).map(Time),
        }
    }
}

/// The caller of this request, with role and fleets.
#[utoipa::path(
    get, path = "/v1/me", tag = "access",
    responses((status = 200, description = "The caller", body = Me))
)]
async fn get_me(Extension(caller): Extension<Caller>) -> Json<Me> {
    Json(caller.into())
}
