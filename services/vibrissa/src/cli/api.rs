//! The API from the command line: who is asked, with which token, and what is made of problems.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, bail};
use clap::Args;
use serde_json::Value;
use url::Url;

/// A supervisor to ask.
#[derive(Debug, Args)]
pub struct ApiArgs {
    /// Where it listens.
    #[arg(long, env = "VIBRISSA_URL", default_value = "http://127.0.0.1:8080")]
    url: Url,
    /// A file with the token; not needed on loopback.
    #[arg(long, env = "VIBRISSA_TOKEN_FILE", value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// As JSON: one line for each row.
    #[arg(long)]
    pub(super) json: bool,
}

/// How long an answer is waited for.
const PATIENCE: Duration = Duration::from_secs(30);
/// Rows of a page.
const PAGE: u32 = 1000;
/// Bytes of an answer at the most.
const ANSWER_BYTES_MAX: u64 = 64 * 1024 * 1024;

/// A supervisor that can be asked.
pub(super) struct Api {
    url: Url,
    authorization: Option<String>,
    agent: ureq::Agent,
}

impl ApiArgs {
    /// Where to ask.
    ///
    /// # Errors
    /// The token cannot be read.
    pub(super) fn open(&self) -> anyhow::Result<Api> {
        let token = match (&self.token_file, std::env::var("VIBRISSA_TOKEN")) {
            (Some(path), _) => {
                Some(std::fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))?)
            }
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
    /// Every row of a list, page by page.
    ///
    /// # Errors
    /// Nobody answers, or with a problem.
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

    /// What is at a path.
    ///
    /// # Errors
    /// Nobody answers, or with a problem.
    pub(super) fn one(&self, path: &str) -> anyhow::Result<Value> {
        self.get(&self.at(path)?)
    }

    /// Asks for an action; sent once, under a key of its own.
    ///
    /// # Errors
    /// Nobody answers, or with a problem.
    pub(super) fn act(&self, path: &str, body: &Value) -> anyhow::Result<Value> {
        let url = self.at(path)?;
        let mut request = self
            .agent
            .post(url.as_str())
            .header("Content-Type", "application/json")
            .header("Idempotency-Key", uuid::Uuid::new_v4().to_string());
        if let Some(authorization) = &self.authorization {
            request = request.header("Authorization", authorization);
        }
        let answer = request.send(body.to_string()).with_context(|| format!("asking {url}"))?;
        read(&url, answer)
    }

    fn at(&self, path: &str) -> anyhow::Result<Url> {
        self.url.join(path).with_context(|| format!("no URL: {}{path}", self.url))
    }

    fn get(&self, url: &Url) -> anyhow::Result<Value> {
        let mut request = self.agent.get(url.as_str());
        if let Some(authorization) = &self.authorization {
            request = request.header("Authorization", authorization);
        }
        read(url, request.call().with_context(|| format!("asking {url}: is a supervisor running there?"))?)
    }
}

/// The answer, or the problem in its own words.
fn read(url: &Url, mut answer: ureq::http::Response<ureq::Body>) -> anyhow::Result<Value> {
    let status = answer.status();
    let body = answer.body_mut().with_config().limit(ANSWER_BYTES_MAX).read_to_vec();
    let body = body.with_context(|| format!("reading the answer of {url}"))?;
    let told: Value = serde_json::from_slice(&body).with_context(|| format!("{url} answered {status}, not in JSON"))?;
    if status.is_success() {
        return Ok(told);
    }
    let detail = told["detail"].as_str().unwrap_or("no detail");
    let hint = if status == 401 { "; give a token with --token-file or VIBRISSA_TOKEN" } else { "" };
    bail!("{status}: {detail}{hint} (request {})", told["request_id"].as_str().unwrap_or("?"))
}

/// A row's field as a text; `-` where there is none.
pub(super) fn text(row: &Value, field: &str) -> String {
    match &row[field] {
        Value::Null => "-".to_owned(),
        Value::String(text) => text.clone(),
        other @ (Value::Bool(_) | Value::Number(_) | Value::Array(_) | Value::Object(_)) => other.to_string(),
    }
}

/// A row's number with so many decimals.
pub(super) fn number(row: &Value, field: &str, decimals: usize) -> String {
    row[field].as_f64().map_or_else(|| "-".to_owned(), |number| format!("{number:.decimals$}"))
}

/// A row's ratio in percent.
pub(super) fn percent(row: &Value, field: &str) -> String {
    row[field].as_f64().map_or_else(|| "-".to_owned(), |ratio| format!("{:.1}", 100.0 * ratio))
}
