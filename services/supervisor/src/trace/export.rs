//! Export of spans to the collector: OTLP as protobuf over HTTP, with ureq, the program's HTTP client. It runs in the
//! thread of the batch processor, which may block.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use async_trait::async_trait;
use opentelemetry_http::{Bytes, HttpClient, HttpError, Request, Response};
use opentelemetry_otlp::{Protocol, RetryPolicy, SpanExporter, WithExportConfig, WithHttpConfig};
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::error::OTelSdkResult;
use opentelemetry_sdk::trace::{SpanData, SpanExporter as Exporter};
use prometheus::IntCounter;
use tokio::time::Instant;
use tracing::{info, warn};

use crate::outgoing::failure;

/// Time limit for an answer of the collector.
const ANSWER_PATIENCE: Duration = Duration::from_secs(5);
/// Size limit of an answer in bytes.
const ANSWER_BYTES_MAX: u64 = 64 * 1024;
/// Shortest interval between two warnings that the collector does not accept traces.
const WARNING_INTERVAL: Duration = Duration::from_secs(60);

/// The last problem with the collector.
type Trouble = Arc<Mutex<Option<String>>>;

/// Sends each batch once; spans that do not arrive are dropped and counted in `dropped`. `queued` is the number of
/// spans in the queue, and is reduced by each batch.
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
    let outage = Mutex::new(OutageLog::default());
    Ok(Counting { exporter, url: url.to_owned(), queued, dropped, trouble, outage })
}

/// An exporter that counts lost spans and logs them from time to time.
#[derive(Debug)]
pub(super) struct Counting {
    exporter: SpanExporter,
    url: String,
    queued: Arc<AtomicUsize>,
    dropped: IntCounter,
    trouble: Trouble,
    outage: Mutex<OutageLog>,
}

/// Limits the rate of warnings: time of the last one, and the spans lost since then.
#[derive(Debug, Default)]
struct OutageLog {
    warned: Option<Instant>,
    lost: usize,
    is_broken: bool,
}

impl OutageLog {
    /// Records `lost` spans. Returns the number lost since the last warning if another warning is due.
    fn broken(&mut self, lost: usize, now: Instant) -> Option<usize> {
        self.is_broken = true;
        self.lost += lost;
        let is_due = self.warned.is_none_or(|warned| now.duration_since(warned) >= WARNING_INTERVAL);
        is_due.then(|| {
            self.warned = Some(now);
            std::mem::take(&mut self.lost)
        })
    }

    /// Clears the failure. Returns whether there was one.
    fn mended(&mut self) -> bool {
        std::mem::take(&mut self.is_broken)
    }
}

impl Exporter for Counting {
    async fn export(&self, batch: Vec<SpanData>) -> OTelSdkResult {
        let spans = batch.len();
        self.queued.fetch_sub(spans, Ordering::AcqRel);
        let sent = self.exporter.export(batch).await;
        let mut outage = self.outage.lock().unwrap_or_else(PoisonError::into_inner);
        match &sent {
            Ok(()) if outage.mended() => info!(url = self.url, "collector accepts traces again"),
            Ok(()) => {}
            Err(problem) => {
                self.dropped.inc_by(spans as u64);
                if let Some(lost) = outage.broken(spans, Instant::now()) {
                    let trouble = self.trouble.lock().unwrap_or_else(PoisonError::into_inner).take();
                    let problem = trouble.unwrap_or_else(|| problem.to_string());
                    warn!(url = self.url, problem, spans = lost, "collector does not accept traces, dropping spans");
                }
            }
        }
        sent
    }

    fn set_resource(&mut self, resource: &Resource) {
        self.exporter.set_resource(resource);
    }
}

/// Lets OpenTelemetry use the program's HTTP client.
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
        let (parts, mut body) =
            self.agent.run(Request::from_parts(parts, &body[..])).map_err(|problem| failure(&problem))?.into_parts();
        let body = body.with_config().limit(ANSWER_BYTES_MAX).read_to_vec().map_err(|problem| failure(&problem))?;
        Ok(Response::from_parts(parts, body.into()))
    }
}

#[async_trait]
impl HttpClient for Client {
    async fn send_bytes(&self, request: Request<Bytes>) -> Result<Response<Bytes>, HttpError> {
        let answer = self.send(request);
        let trouble = match &answer {
            Ok(answer) if answer.status().is_success() => None,
            Ok(answer) => Some(format!("it answers with status {}", answer.status())),
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
        let mut outage = OutageLog::default();
        assert!(!outage.mended());
        assert_eq!(outage.broken(3, begun), Some(3));
        assert_eq!(outage.broken(4, begun + Duration::from_secs(59)), None);
        assert_eq!(outage.broken(5, begun + WARNING_INTERVAL), Some(9));
        assert!(outage.mended());
        assert!(!outage.mended());
        assert_eq!(outage.broken(1, begun + WARNING_INTERVAL + Duration::from_secs(1)), None);
    }
}
