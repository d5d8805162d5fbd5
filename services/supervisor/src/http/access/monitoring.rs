//! Access to `/readyz` and `/metrics` on the main listener, which also serves everything else.

use axum::extract::{Request, State};
use axum::http::header;
use axum::http::request::Parts;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::origin::require_direct;
use super::{Access, Gate, Scope};
use crate::http::problem::{Kind, Problem};
use vibrissa_store::Store;

/// Lets a request pass that comes from this machine to a loopback listener, or has a token for all fleets.
pub(in crate::http) async fn check(State(gate): State<Gate>, request: Request, next: Next) -> Response {
    let (parts, body) = request.into_parts();
    match admit(&gate.access, &gate.store, &parts).await {
        Ok(()) => next.run(Request::from_parts(parts, body)).await,
        Err(problem) => problem.into_response(),
    }
}

async fn admit(access: &Access, store: &Store, request: &Parts) -> Result<(), Problem> {
    let is_local = access.is_loopback && require_direct(request.version, &request.headers).is_ok();
    if is_local && !request.headers.contains_key(header::AUTHORIZATION) {
        return Ok(());
    }
    let identified = async { access.identify(store, &access.credential(request)?).await };
    let caller = match identified.await {
        Ok(caller) => caller,
        Err(problem) => return Err(access.refused(request, problem)),
    };
    access.limit(&caller.actor)?;
    if caller.scope == Scope::All {
        return Ok(());
    }
    Err(Problem::new(
        Kind::Forbidden,
        "this covers every fleet: use a token for all fleets (vibrissa token create --role viewer --all-fleets), or \
         the listener http.monitoring_listen",
    ))
}
