//! The way to the collector: OTLP as protobuf over HTTP, by the client that the program has anyway. It runs in the thread
//! of the batch processor, which may wait.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use async_trait::async_trait;
use opentelemetry_http::{Bytes, HttpClient, HttpError, Request, Response};
use opentelemetry_otlp::{Protocol, RetryPolicy, SpanExporter, WithExportConfig, WithHttpConfig};
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::error::OTelSdkResult;
use opentelemetry_sdk::trace::{SpanData, SpanExporter as Exporter};
use prometheus::IntCounter;
use tracing::{info, warn};

/// How long a collector may take for an answer.
const ANSWER_PATIENCE: Duration = Duration::from_secs(5);
/// Bytes of an answer that are read at the most.
const ANSWER_BYTES_MAX: u64 = 64 * 1024;
/// How often it is told that a collector takes nothing.
const COMPLAIN_EVERY: Duration = Duration::from_secs(60);

/// What went wrong last between us and the collector.
type Trouble = Arc<Mutex<Option<String>>>;

/// Sends what it is given once: what does not arrive is dropped and counted. `queued` loses what it takes.
pub(super) fn exporter(url: &str, queued: Arc<AtomicUsize>, dropped: IntCounter) -> Result<Counting, String> {
    let trouble = Trouble::default();
    let exporter = SpanExporter::builder()
        .with_http()
        .with_http_client(Client::new(trouble.clone()))
        .with_endpoint(url)
        .with_protocol(Protocol::HttpBinary)
        .with_timeout(ANSWER_PATIENCE)
        .with_retry_policy(RetryPolicy::disabled())
        .build()
        .map_err(|problem| problem.to_string())?;
    let silence = Mutex::new(Silence::default());
    Ok(Counting { exporter, url: url.to_owned(), queued, dropped, trouble, silence })
}

/// An exporter that knows what was lost, and says so now and then.
#[derive(Debug)]
pub(super) struct Counting {
    exporter: SpanExporter,
    url: String,
    queued: Arc<AtomicUsize>,
    dropped: IntCounter,
    trouble: Trouble,
    silence: Mutex<Silence>,
}

/// When it was last said that the collector takes nothing, and what was lost since.
#[derive(Debug, Default)]
struct Silence {
    told: Option<Instant>,
    lost: usize,
    is_broken: bool,
}

impl Silence {
    /// How much was lost since it was last told; nothing if that was just now.
    fn broken(&mut self, lost: usize, now: Instant) -> Option<usize> {
        self.is_broken = true;
        self.lost += lost;
        let is_due = self.told.is_none_or(|told| now.duration_since(told) >= COMPLAIN_EVERY);
        is_due.then(|| {
            self.told = Some(now);
            std::mem::take(&mut self.lost)
        })
    }

    /// Whether it was broken before.
    fn mended(&mut self) -> bool {
        std::mem::take(&mut self.is_broken)
    }
}

impl Exporter for Counting {
    async fn export(&self, batch: Vec<SpanData>) -> OTelSdkResult {
        let spans = batch.len();
        self.queued.fetch_sub(spans, Ordering::AcqRel);
        let sent = self.exporter.export(batch).await;
        let mut silence = self.silence.lock().unwrap_or_else(PoisonError::into_inner);
        match &sent {
            Ok(()) if silence.mended() => info!(url = self.url, "the collector takes traces again"),
            Ok(()) => {}
            Err(problem) => {
                self.dropped.inc_by(spans as u64);
                if let Some(lost) = silence.broken(spans, Instant::now()) {
                    let told = self.trouble.lock().unwrap_or_else(PoisonError::into_inner).take();
                    let problem = told.unwrap_or_else(|| problem.to_string());
                    warn!(url = self.url, problem, spans = lost, "the collector takes no traces; they are dropped");
                }
            }
        }
        sent
    }

    fn set_resource(&mut self, resource: &Resource) {
        self.exporter.set_resource(resource);
    }
}

/// The program's HTTP client, as OpenTelemetry wants one.
#[derive(Debug)]
struct Client {
    agent: ureq::Agent,
    trouble: Trouble,
}

impl Client {
    fn new(trouble: Trouble) -> Self {
        let agent = ureq::Agent::config_builder()
            .timeout_global(Some(ANSWER_PATIENCE))
            .max_redirects(0)
            .http_status_as_error(false)
            .build()
            .new_agent();
        Self { agent, trouble }
    }

    fn send(&self, request: Request<Bytes>) -> Result<Response<Bytes>, HttpError> {
        let (parts, body) = request.into_parts();
        let (parts, mut body) = self.agent.run(Request::from_parts(parts, &body[..]))?.into_parts();
        let body = body.with_config().limit(ANSWER_BYTES_MAX).read_to_vec()?;
        Ok(Response::from_parts(parts, body.into()))
    }
}

#[async_trait]
impl HttpClient for Client {
    async fn send_bytes(&self, request: Request<Bytes>) -> Result<Response<Bytes>, HttpError> {
        let answer = self.send(request);
        let trouble = match &answer {
            Ok(answer) if answer.status().is_success() => None,
            Ok(answer) => Some(format!("it answers {}", answer.status())),
            Err(problem) => Some(problem.to_string()),
        };
        *self.trouble.lock().unwrap_or_else(PoisonError::into_inner) = trouble;
        answer
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_collector_that_is_away_is_complained_of_once_a_minute_with_all_that_was_lost() {
        let begun = Instant::now();
        let mut silence = Silence::default();
        assert!(!silence.mended());
        assert_eq!(silence.broken(3, begun), Some(3));
        assert_eq!(silence.broken(4, begun + Duration::from_secs(59)), None);
        assert_eq!(silence.broken(5, begun + COMPLAIN_EVERY), Some(9));
        assert!(silence.mended());
        assert!(!silence.mended());
        assert_eq!(silence.broken(1, begun + COMPLAIN_EVERY + Duration::from_secs(1)), None);
    }
}
