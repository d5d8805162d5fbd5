//! Compensation policy of a fleet, and its history.

use axum::extract::State;
use axum::http::{HeaderMap, header};
use axum::response::Response;
use serde::{Deserialize, Serialize};
use serde_json::json;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_core::policy::PolicyParams;
use vibrissa_core::policy_numbers;

use super::paths::FleetPath;
use crate::http::App;
use crate::http::asking::{Asker, ask, reason, replaced_before};
use crate::http::extract::{Body, Path, Query};
use crate::http::listing::Listing;
use crate::http::page::{Page, list_query};
use crate::http::problem::{Kind, Problem};
use crate::http::version::{etag, lists, versioned};
use crate::http::words::{LongerForShorterWord, ModeWord, ObjectiveWord};
use vibrissa_store::lists::actions::ActionRow;
use vibrissa_store::lists::policies::{POLICIES, PolicyRow, PolicySort};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(get_policy, put_policy)).routes(routes!(list_policies))
}

macro_rules! policy_body {
    ([$($name:ident {
        key: $key:tt, default: $default:tt, min: $min:tt, max: $max:tt, unit: $unit:tt, title: $title:tt, doc: $doc:tt,
    })+]) => {
        /// A complete policy.
        #[derive(Debug, Deserialize, Serialize, ToSchema)]
        #[serde(deny_unknown_fields)]
        #[schema(as = NewPolicy)]
        pub struct PolicyBody {
            /// Whether compensations need approval.
            pub mode: ModeWord,
            /// Objective of the setpoint solver.
            pub objective: ObjectiveWord,
            /// Whether a longer whisker may compensate for a shorter one.
            pub longer_for_shorter: LongerForShorterWord,
            $(
                #[doc = $doc]
                #[schema(
                    minimum = $min, maximum = $max,
                    extensions(("x-label" = json!($title)), ("x-unit" = json!($unit)))
                )]
                pub $name: f64,
            )+
            /// Reason in free text, at most 1000 characters.
            #[schema(max_length = 1000)]
            #[serde(skip_serializing)]
            pub reason: Option<String>,
        }

        impl PolicyBody {
            /// Checks the numbers' ranges.
            pub(super) fn check(&self) -> Result<(), Problem> {
                for (number, value) in PolicyParams::NUMBERS.iter().zip([$(self.$name),+]) {
                    if !(number.min..=number.max).contains(&value) {
                        let what = format!("must be from {} to {}, not {value}", number.min, number.max);
                        return Err(Problem::invalid(number.name, what));
                    }
                }
                Ok(())
            }
        }
    };
}
policy_numbers!(policy_body);

/// Parameters of the action that sets a policy.
#[derive(Serialize)]
struct Parameters {
    expected_version: i64,
    #[serde(flatten)]
    policy: PolicyBody,
}

/// Version of the policy that is in force in a fleet.
pub(super) async fn version_of(app: &App, fleet: &str) -> Result<i64, Problem> {
    Ok(app.store.policy_version(fleet).await?)
}

async fn in_force(app: &App, at: &FleetPath) -> Result<PolicyRow, Problem> {
    if !app.store.has_fleet(at.fleet.as_str()).await? {
        return Err(Problem::not_found(at));
    }
    let set: Option<PolicyRow> = app.store.first(&POLICIES, at.filters()).await?;
    if let Some(set) = set {
        return Ok(set);
    }
    // The version counts also if its policy cannot be read, so that another one can replace it.
    let version = app.store.policy_version(at.fleet.as_str()).await?;
    Ok(PolicyRow { version, ..PolicyRow::configured(at.fleet.to_string(), &app.params.policy) })
}

/// The policy in force. A change must send its `ETag` as `If-Match`.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/policy", tag = "policy",
    params(
        FleetPath,
        ("If-None-Match" = Option<String>, Header, description = "`ETag` of the policy that is known; 304 if it is in force")
    ),
    responses(
        (status = 200, description = "The policy", body = PolicyRow, headers(("ETag" = String, description = "Its version"))),
        (status = 304, description = "The known policy is in force", headers(("ETag" = String, description = "Its version")))
    )
)]
async fn get_policy(
    State(app): State<App>,
    Path(at): Path<FleetPath>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let policy = in_force(&app, &at).await?;
    Ok(versioned(&headers, policy.version, &policy))
}

/// Set another policy in place of the one that was read. Later decisions follow it at once.
#[utoipa::path(
    put, path = "/v1/fleets/{fleet}/policy", tag = "policy",
    params(
        FleetPath,
        ("If-Match" = Option<String>, Header, description = "`ETag` of the policy that was read; 428 if missing"),
        ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")
    ),
    request_body = PolicyBody,
    responses(
        (status = 200, description = "The policy is in force", body = ActionRow),
        (status = 202, description = "Pending; poll the action", body = ActionRow)
    ),
    extensions(("x-required-role" = json!("ENGINEER")))
)]
async fn put_policy(
    State(app): State<App>,
    Path(at): Path<FleetPath>,
    headers: HeaderMap,
    asker: Asker,
    Body(mut body): Body<PolicyBody>,
) -> Result<Response, Problem> {
    body.check()?;
    let why = reason(body.reason.take())?;
    let expected_version = match replaced_before(&app, &asker, "POLICY", &at.fleet, &headers).await? {
        Some(version) => version,
        None => expected(&app, &at, &headers).await?,
    };
    let parameters = json!(Parameters { expected_version, policy: body });
    let mut action = asker.action("POLICY", &parameters, why);
    action.fleet = Some(at.fleet.to_string());
    ask(&app, &at.fleet, &action).await
}

/// The version in the caller's `If-Match`, if it is still current. The engine checks it once more.
async fn expected(app: &App, at: &FleetPath, headers: &HeaderMap) -> Result<i64, Problem> {
    let now = in_force(app, at).await?.version;
    let Some(tag) = headers.get(header::IF_MATCH) else {
        return Err(Problem::new(
            Kind::VersionMissing,
            format!("read the policy first, and send its ETag as If-Match: {}", etag(now)),
        ));
    };
    if lists(headers, header::IF_MATCH, now) {
        return Ok(now);
    }
    let tag = tag.to_str().unwrap_or_default();
    Err(Problem::new(Kind::VersionChanged, format!("the policy in force is {}, not {tag}: read it again", etag(now))))
}

list_query! {
    /// Pagination of the history of policies.
    pub struct PoliciesQuery by PolicySort {}
}

/// All policies that were set, with actor and reason.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/policy/history", tag = "policy", params(FleetPath, PoliciesQuery),
    responses((status = 200, description = "A page of policies", body = Page<PolicyRow>))
)]
async fn list_policies(
    State(app): State<App>,
    Path(at): Path<FleetPath>,
    listing: Listing,
    Query(query): Query<PoliciesQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters.extend(at.filters());
    listing.answer::<PolicyRow>(&app, &POLICIES, selection).await
}
