//! Client of the API for the command line.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context as _, anyhow, bail};
use clap::Args;
use serde_json::Value;
use url::Url;
use vibrissa_host::random;
use vibrissa_store::secret::Secret;

use crate::config::address::web_url;
use vibrissa_supervisor::outgoing::failure;

/// Address of a supervisor, and the token for it.
#[derive(Debug, Args)]
pub struct ConnectionArgs {
    /// URL of the supervisor.
    #[arg(long, env = "VIBRISSA_URL", default_value = "http://127.0.0.1:8080", value_parser = web_url)]
    url: Url,
    /// File with the API token; not needed on loopback.
    #[arg(long, env = "VIBRISSA_TOKEN_FILE", value_name = "FILE")]
    token_file: Option<PathBuf>,
}

/// Arguments of the commands that print answers of the API.
#[derive(Debug, Args)]
pub struct ApiArgs {
    #[command(flatten)]
    connection: ConnectionArgs,
    /// Print JSON, one line per row.
    #[arg(long)]
    pub(super) json: bool,
}

/// Time limit of a request.
const PATIENCE: Duration = Duration::from_secs(30);
/// Rows per page.
const PAGE: u32 = 1000;
/// Size limit of an answer, in bytes.
const ANSWER_BYTES_MAX: u64 = 64 * 1024 * 1024;

/// Client of a supervisor's API.
pub(super) struct Api {
    url: Url,
    authorization: Option<String>,
    agent: ureq::Agent,
}

impl ApiArgs {
    /// A client with these arguments; sends nothing yet.
    ///
    /// # Errors
    /// The token file cannot be read.
    pub(super) fn open(&self) -> anyhow::Result<Api> {
        self.connection.open()
    }
}

impl ConnectionArgs {
    /// A client with these arguments; sends nothing yet.
    ///
    /// # Errors
    /// The token file cannot be read.
    pub(super) fn open(&self) -> anyhow::Result<Api> {
        let token = match (&self.token_file, std::env::var("VIBRISSA_TOKEN")) {
            (Some(path), _) => Some(Secret::from_file(path).map_err(anyhow::Error::msg)?.reveal().to_owned()),
            (None, Ok(token)) => Some(token),
            (None, Err(_)) => None,
        };
        let agent = ureq::Agent::config_builder()
            .timeout_global(Some(PATIENCE))
            .http_status_as_error(false)
            .max_redirects(0)
            .build()
            .new_agent();
        let authorization = token.map(|token| format!("Bearer {}", token.trim()));
        Ok(Api { url: self.url.clone(), authorization, agent })
    }
}

impl Api {
    /// All rows of a list, page by page.
    ///
    /// # Errors
    /// The supervisor does not answer, or refuses the request.
    pub(super) fn rows(&self, path: &str, filters: &[(&str, Option<String>)]) -> anyhow::Result<Vec<Value>> {
        let mut rows = Vec::new();
        let mut cursor: Option<String> = None;
        loop {
            let mut url = self.at(path)?;
            {
                let mut query = url.query_pairs_mut();
                query.append_pair("limit", &PAGE.to_string());
                for (name, value) in filters {
                    if let Some(value) = value {
                        query.append_pair(name, value);
                    }
                }
                if let Some(cursor) = &cursor {
                    query.append_pair("cursor", cursor);
                }
            }
            let mut page = self.get(&url)?;
            if let Some(Value::Array(items)) = page.get_mut("items").map(Value::take) {
                rows.extend(items);
            }
            cursor = page["next_cursor"].as_str().map(ToOwned::to_owned);
            if cursor.is_none() {
                return Ok(rows);
            }
        }
    }

    /// The first rows of a list.
    ///
    /// # Errors
    /// The supervisor does not answer, or refuses the request.
    pub(super) fn page(&self, path: &str, filters: &[(&str, String)], limit: u32) -> anyhow::Result<Vec<Value>> {
        let mut url = self.at(path)?;
        url.query_pairs_mut().append_pair("limit", &limit.to_string()).extend_pairs(filters);
        let mut page = self.get(&url)?;
        match page.get_mut("items").map(Value::take) {
            Some(Value::Array(items)) => Ok(items),
            _ => Ok(Vec::new()),
        }
    }

    /// The resource at a path.
    ///
    /// # Errors
    /// The supervisor does not answer, or refuses the request.
    pub(super) fn one(&self, path: &str) -> anyhow::Result<Value> {
        self.get(&self.at(path)?)
    }

    /// Requests an action, once, under an idempotency key of its own.
    ///
    /// # Errors
    /// The supervisor does not answer, or refuses the request.
    pub(super) fn act(&self, path: &str, body: &Value) -> anyhow::Result<Value> {
        let url = self.at(path)?;
        let mut request = self
            .agent
            .post(url.as_str())
            .header("Content-Type", "application/json")
            .header("Idempotency-Key", random::hex());
        if let Some(authorization) = &self.authorization {
            request = request.header("Authorization", authorization);
        }
        let answer =
            request.send(body.to_string()).map_err(|problem| anyhow!("requesting {url}: {}", failure(&problem)))?;
        read(&url, answer)
    }

    /// Requests the removal of a resource, once, under an idempotency key of its own.
    ///
    /// # Errors
    /// The supervisor does not answer, or refuses the request.
    pub(super) fn remove(&self, path: &str, body: &Value) -> anyhow::Result<Value> {
        let url = self.at(path)?;
        let mut request = self
            .agent
            .delete(url.as_str())
            .header("Content-Type", "application/json")
            .header("Idempotency-Key", random::hex());
        if let Some(authorization) = &self.authorization {
            request = request.header("Authorization", authorization);
        }
        let request = request.force_send_body();
        let answer = request.send(body.to_string()).with_context(|| format!("requesting {url}"))?;
        read(&url, answer)
    }

    /// A path of the API, below the path of a proxy.
    fn at(&self, path: &str) -> anyhow::Result<Url> {
        let mut base = self.url.clone();
        base.set_path(&format!("{}/", base.path().trim_end_matches('/')));
        base.join(path.trim_start_matches('/')).with_context(|| format!("invalid URL: {}{path}", self.url))
    }

    fn get(&self, url: &Url) -> anyhow::Result<Value> {
        let mut request = self.agent.get(url.as_str());
        if let Some(authorization) = &self.authorization {
            request = request.header("Authorization", authorization);
        }
        let away = |problem| anyhow!("requesting {url}: is a supervisor running there? {}", failure(&problem));
        read(url, request.call().map_err(away)?)
    }
}

/// The JSON of an answer, or an error with the detail of the problem.
fn read(url: &Url, mut answer: ureq::http::Response<ureq::Body>) -> anyhow::Result<Value> {
    let status = answer.status();
    let body = answer.body_mut().with_config().limit(ANSWER_BYTES_MAX).read_to_vec();
    let body = body.map_err(|problem| anyhow!("reading the answer of {url}: {}", failure(&problem)))?;
    let document: Value =
        serde_json::from_slice(&body).with_context(|| format!("{url} answered {status} without JSON"))?;
    if status.is_success() {
        return Ok(document);
    }
    let detail = document["detail"].as_str().unwrap_or("no detail");
    let hint = if status == 401 { "; give a token with --token-file or VIBRISSA_TOKEN" } else { "" };
    bail!("{status}: {detail}{hint} (request {})", document["request_id"].as_str().unwrap_or("?"))
}

/// A row's field as text; `-` for null.
pub(super) fn text(row: &Value, field: &str) -> String {
    match &row[field] {
        Value::Null => "-".to_owned(),
        Value::String(text) => text.clone(),
        other @ (Value::Bool(_) | Value::Number(_) | Value::Array(_) | Value::Object(_)) => other.to_string(),
    }
}

/// A row's number with this many decimals; `-` for null.
pub(super) fn number(row: &Value, field: &str, decimals: usize) -> String {
    row[field].as_f64().map_or_else(|| "-".to_owned(), |number| format!("{number:.decimals$}"))
}

/// A row's ratio in percent; `-` for null.
pub(super) fn percent(row: &Value, field: &str) -> String {
    row[field].as_f64().map_or_else(|| "-".to_owned(), |ratio| format!("{:.1}", 100.0 * ratio))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The path was left out: the request, with its token, went to another application of the host.
    #[test]
    fn regress_requests_stay_below_the_path_of_a_proxy() {
        for (url, expected) in [
            ("https://h", "https://h/v1/whiskers"),
            ("http://127.0.0.1:8080/", "http://127.0.0.1:8080/v1/whiskers"),
            ("https://h/vibrissa", "https://h/vibrissa/v1/whiskers"),
            ("https://h/halls/vibrissa/", "https://h/halls/vibrissa/v1/whiskers"),
        ] {
            let agent = ureq::Agent::config_builder().build().new_agent();
            let api = Api { url: web_url(url).unwrap(), authorization: None, agent };
            assert_eq!(api.at("/v1/whiskers").unwrap().as_str(), expected);
        }
    }
}
