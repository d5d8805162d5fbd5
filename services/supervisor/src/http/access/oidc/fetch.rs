//! Requests to the identity provider: on threads that may block, without redirects, with limits of time and size.

use std::time::Duration;

use openidconnect::{HttpRequest, HttpResponse};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use vibrissa_host::task;
use vibrissa_protocol::plain;

use crate::outgoing::failure;

/// Time limit of a request.
const PATIENCE: Duration = Duration::from_secs(5);
/// Size limit of an answer, in bytes.
const ANSWER_BYTES_MAX: u64 = 1024 * 1024;

/// The provider does not answer, or not as expected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(super) struct Away(pub(super) String);

/// A provider's document about itself (OpenID Connect Discovery). Whoever needs a member says so if it is missing.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Discovery {
    pub(super) issuer: Option<String>,
    pub(super) authorization_endpoint: Option<String>,
    pub(super) token_endpoint: Option<String>,
    pub(super) end_session_endpoint: Option<String>,
    pub(super) jwks_uri: Option<String>,
}

/// The provider's document about itself.
pub(super) fn discover(issuer: &str) -> Result<Discovery, Away> {
    get(&format!("{}/.well-known/openid-configuration", issuer.trim_end_matches('/')))
}

/// The JSON at an address.
pub(super) fn get<T: DeserializeOwned>(url: &str) -> Result<T, Away> {
    let request = ureq::http::Request::get(url).header("accept", "application/json").body(());
    let request = request.map_err(|_| Away(format!("{url}: it is no address of the web")))?;
    let answer = agent().run(request).map_err(|problem| Away(format!("{url}: {}", failure(&problem))))?;
    let answer = read(url, answer)?;
    if !answer.status().is_success() {
        return Err(Away(format!("{url}: the provider answered {}", answer.status())));
    }
    serde_json::from_slice(answer.body())
        .map_err(|problem| Away(format!("{url}: unexpected JSON: {}", plain::json(&problem.to_string()))))
}

/// Sends a request that `openidconnect` has made. Answers that a later request may not get are errors.
pub(super) fn send(request: HttpRequest) -> Result<HttpResponse, Away> {
    let url = request.uri().to_string();
    let answer = agent().run(request).map_err(|problem| Away(format!("{url}: {}", failure(&problem))))?;
    let answer = read(&url, answer)?;
    let is_passing = answer.status().is_server_error() || matches!(answer.status().as_u16(), 408 | 429);
    if is_passing { Err(Away(format!("{url}: the provider answered {}", answer.status()))) } else { Ok(answer) }
}

fn agent() -> ureq::Agent {
    let config = ureq::Agent::config_builder().timeout_global(Some(PATIENCE)).max_redirects(0);
    config.http_status_as_error(false).build().new_agent()
}

fn read(url: &str, answer: ureq::http::Response<ureq::Body>) -> Result<HttpResponse, Away> {
    let (parts, mut body) = answer.into_parts();
    let body = body.with_config().limit(ANSWER_BYTES_MAX).read_to_vec();
    Ok(HttpResponse::from_parts(parts, body.map_err(|problem| Away(format!("{url}: {}", failure(&problem))))?))
}

/// Runs a request on a thread that may block.
pub(super) async fn blocking<T: Send + 'static, E: From<Away> + Send + 'static>(
    work: impl FnOnce() -> Result<T, E> + Send + 'static,
) -> Result<T, E> {
    task::blocking(work).await.unwrap_or_else(|problem| Err(Away(problem.to_string()).into()))
}
