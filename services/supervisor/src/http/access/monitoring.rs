//! Who may see what the service says of itself (`/readyz`, `/metrics`) where everything else is served, too.

use axum::extract::{Request, State};
use axum::http::{HeaderMap, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::{Access, Gate, Scope, require_direct};
use crate::http::problem::{Kind, Problem};
use crate::store::Store;

/// Lets a request in that comes from this machine to a listener on loopback, or with a token for all fleets.
pub(in crate::http) async fn check(State(gate): State<Gate>, request: Request, next: Next) -> Response {
    match admit(&gate.access, &gate.store, request.headers()).await {
        Ok(()) => next.run(request).await,
        Err(problem) => problem.into_response(),
    }
}

async fn admit(access: &Access, store: &Store, headers: &HeaderMap) -> Result<(), Problem> {
    let is_local = access.is_loopback && require_direct(headers).is_ok();
    if is_local && !headers.contains_key(header::AUTHORIZATION) {
        return Ok(());
    }
    let caller = match access.caller(store, headers).await {
        Ok(caller) => caller,
        Err(problem) => return Err(access.limit("nobody").err().unwrap_or(problem)),
    };
    access.limit(&caller.actor)?;
    if caller.scope == Scope::All {
        return Ok(());
    }
    Err(Problem::new(
        Kind::Forbidden,
        "this tells of every fleet: it needs a token for all of them (vibrissa token create --role viewer --all-fleets), or ask \
         the listener of http.monitoring_listen",
    ))
}
