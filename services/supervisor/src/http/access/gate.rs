//! The check of each request: the caller's role must allow the route, and its scope cover the fleet in the path.

use std::sync::Arc;

use axum::extract::{MatchedPath, RawPathParams, Request, State};
use axum::http::request::Parts;
use axum::http::{HeaderValue, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::{Access, Caller, Credential};
use crate::http::document::{Need, Roles};
use crate::http::problem::{Kind, Problem};
use vibrissa_store::Store;

/// State of the access check.
#[derive(Debug, Clone)]
pub struct Gate {
    /// Database of the tokens.
    pub store: Store,
    /// Decides who is let in.
    pub access: Access,
    /// Role that each route requires.
    pub roles: Arc<Roles>,
}

/// Lets a request pass if the caller's role allows the route and the caller's scope covers the fleet in the path.
pub async fn check(State(gate): State<Gate>, params: RawPathParams, request: Request, next: Next) -> Response {
    let (mut parts, body) = request.into_parts();
    let path = parts.extensions.get::<MatchedPath>().cloned();
    let path = path.as_ref().map(MatchedPath::as_str).unwrap_or_default();
    match admit(&gate, &params, &parts, path).await {
        Ok((caller, credential)) => {
            parts.extensions.insert(caller);
            parts.extensions.insert(credential);
            next.run(Request::from_parts(parts, body)).await
        }
        Err(problem) => {
            let is_method = problem.kind == Kind::MethodNotAllowed;
            let mut response = problem.into_response();
            let allowed = HeaderValue::from_str(&gate.roles.methods(path).join(","));
            if let (true, Ok(allowed)) = (is_method, allowed) {
                response.headers_mut().insert(header::ALLOW, allowed);
            }
            response
        }
    }
}

async fn admit(
    gate: &Gate,
    params: &RawPathParams,
    request: &Parts,
    path: &str,
) -> Result<(Caller, Credential), Problem> {
    let identified = async {
        let credential = gate.access.credential(request)?;
        Ok((gate.access.identify_request(&gate.store, request, &credential).await?, credential))
    };
    let (caller, credential) = match identified.await {
        Ok(identified) => identified,
        Err(problem) => return Err(gate.access.refused(request, problem)),
    };
    gate.access.limit(&caller.actor)?;
    let needed = match gate.roles.needed(&request.method, path) {
        Need::Role(role) => role,
        Need::NoSuchMethod => {
            return Err(Problem::new(
                Kind::MethodNotAllowed,
                "this path does not support the method; see /openapi.json",
            ));
        }
        Need::Undeclared => {
            tracing::error!(path, "refusing a request: the route declares no role");
            return Err(Problem::new(Kind::Forbidden, "this route is closed because it declares no role"));
        }
    };
    if caller.role < needed {
        return Err(Problem::new(
            Kind::Forbidden,
            format!("this requires the role {}; your token has {}", needed.word(), caller.role.word()),
        ));
    }
    let fleet = params.iter().find(|(name, _)| *name == "fleet").map(|(_, fleet)| fleet);
    if let Some(fleet) = fleet.filter(|fleet| !caller.scope.covers(fleet)) {
        return Err(Problem::new(Kind::Forbidden, format!("your token does not cover the fleet {fleet:?}")));
    }
    Ok((caller, credential))
}

#[cfg(test)]
mod tests {
    use axum::Router;
    use axum::middleware::{from_fn, from_fn_with_state};
    use axum::routing::{any, get};
    use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
    use tokio::net::{TcpListener, TcpStream};

    use super::super::{AccessOptions, origin};
    use super::*;
    use crate::http::document;
    use vibrissa_store::DatabaseAddress;

    /// Statuses of requests to a router whose document declares `GET /v1/told` only.
    async fn statuses(requests: &[(&str, &str)]) -> Vec<u16> {
        let folder = std::env::temp_dir().join(format!("vibrissa-access-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let store = Store::open(&DatabaseAddress::Sqlite(folder.join("v.sqlite3")), "test").await.unwrap();
        let mut document = document::base();
        let item: utoipa::openapi::PathItem =
            serde_json::from_value(serde_json::json!({ "get": { "responses": {} } })).unwrap();
        document.paths.paths.insert("/v1/told".to_owned(), item);
        let roles = Arc::new(Roles::of(&mut document));
        let access = Access::new(&AccessOptions::default(), std::net::Ipv4Addr::LOCALHOST.into());
        let router = Router::new()
            .route("/v1/told", get(async || "told").post(async || "not told"))
            .route("/v1/not-told", any(async || "not told"))
            .route_layer(from_fn_with_state(Gate { store, access, roles }, check))
            .layer(from_fn(origin::refuse_other_sites));
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let serving = vibrissa_host::task::spawn(async move { axum::serve(listener, router).await });
        let mut statuses = Vec::new();
        for (method, path) in requests {
            let mut stream = TcpStream::connect(address).await.unwrap();
            let request = format!("{method} {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
            stream.write_all(request.as_bytes()).await.unwrap();
            let mut answer = String::new();
            stream.read_to_string(&mut answer).await.unwrap();
            statuses.push(answer.split(' ').nth(1).unwrap().parse().unwrap());
        }
        serving.abort();
        std::fs::remove_dir_all(&folder).unwrap();
        statuses
    }

    #[tokio::test]
    async fn regress_a_route_or_method_without_a_role_is_closed_to_everybody() {
        let requests = [
            ("GET", "/v1/told"),
            ("HEAD", "/v1/told"),
            ("POST", "/v1/told"),
            ("GET", "/v1/not-told"),
            ("POST", "/v1/not-told"),
        ];
        assert_eq!(statuses(&requests).await, [200, 200, 405, 403, 403]);
    }
}
