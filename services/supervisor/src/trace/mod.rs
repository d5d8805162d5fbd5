//! Traces for OpenTelemetry, where somebody has a collector: one trace for each setpoint, from the contact that raised the
//! suspicion to the answer of the robot, and one for each request.
//!
//! A setpoint's trace has its `command_id` as its id, so that whoever has the one has the other, and a supervisor that
//! takes a fleet over goes on with the traces of its predecessor. Spans are put together when what they tell is over, and
//! given to a bounded queue, from which a thread of its own sends them: nobody waits for a collector, and what it does not
//! take is dropped and counted. Without a collector there is nothing of it: no thread, no queue, no spans.
//!
//! Read in this order: `span` (one span), `life` (a setpoint's trace), `story` (what a step of the core is told as),
//! `request`, `export` (the way to the collector).

mod export;
mod life;
mod request;
mod span;
mod story;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use opentelemetry::{InstrumentationScope, KeyValue};
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::trace::{BatchConfigBuilder, BatchSpanProcessor, SpanData, SpanExporter, SpanProcessor};
use prometheus::IntCounter;
use tracing::warn;

pub(crate) use life::{Lives, Untold};
pub(crate) use story::{Asked, Step, is_told};

/// Spans that wait for the collector at the most; beyond it they are dropped.
const QUEUE_SPANS: usize = 4096;
/// Spans that are sent at once at the most.
const BATCH_SPANS: usize = 512;
/// How often spans are sent.
const SEND_EVERY: Duration = Duration::from_secs(1);
/// How long the last ones may take when the service stops.
const STOP_PATIENCE: Duration = Duration::from_secs(2);

/// Where traces go.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceOptions {
    /// The collector's URL for traces, `http://HOST:4318/v1/traces` as a rule.
    pub url: String,
    /// Share of the requests that only look which is traced, 0 to 1; those that change something always are.
    pub sample_ratio: f64,
}

/// Why traces cannot be sent.
#[derive(Debug, thiserror::Error)]
#[error(
    "traces cannot be sent to {url}: {problem}; correct traces.otlp_endpoint, or the variables OTEL_EXPORTER_OTLP_*"
)]
pub struct TraceError {
    url: String,
    problem: String,
}

/// The way to the collector. Copies share it.
#[derive(Debug, Clone)]
pub struct Traces(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    processor: BatchSpanProcessor,
    scope: InstrumentationScope,
    /// Spans in the queue.
    queued: Arc<AtomicUsize>,
    dropped: IntCounter,
    sample_ratio: f64,
    /// The database, in OpenTelemetry's words.
    database: &'static str,
}

impl Traces {
    /// Starts the thread that sends. A collector that is away is no error: its spans are dropped, and counted in `dropped`.
    ///
    /// # Errors
    /// The URL is none, or the environment asks for what is not built in.
    pub fn start(
        options: &TraceOptions,
        supervisor: &str,
        database: &'static str,
        dropped: IntCounter,
    ) -> Result<Self, TraceError> {
        let queued = Arc::new(AtomicUsize::new(0));
        let exporter = export::exporter(&options.url, queued.clone(), dropped.clone())
            .map_err(|problem| TraceError { url: options.url.clone(), problem })?;
        let version = env!("CARGO_PKG_VERSION");
        let resource = Resource::builder_empty()
            .with_service_name("vibrissa")
            .with_attributes([
                KeyValue::new("service.instance.id", supervisor.to_owned()),
                KeyValue::new("service.version", version),
            ])
            .build();
        let mut processor = processor(exporter);
        processor.set_resource(&resource);
        let scope = InstrumentationScope::builder("vibrissa").with_version(version).build();
        let sample_ratio = options.sample_ratio;
        Ok(Self(Arc::new(Inner { processor, scope, queued, dropped, sample_ratio, database })))
    }

    /// Puts a span into the queue, if there is room. Never waits.
    fn submit(&self, span: SpanData) {
        if self.0.queued.fetch_add(1, Ordering::AcqRel) >= QUEUE_SPANS {
            self.0.queued.fetch_sub(1, Ordering::AcqRel);
            self.drop_one();
            return;
        }
        self.0.processor.on_end(span);
    }

    /// Counts a span that nobody will see.
    fn drop_one(&self) {
        self.0.dropped.inc();
    }

    /// Sends what waits, for two seconds at the most; nothing is sent after it.
    pub async fn stop(&self) {
        let traces = self.clone();
        let stopped =
            tokio::task::spawn_blocking(move || traces.0.processor.shutdown_with_timeout(STOP_PATIENCE)).await;
        if !matches!(stopped, Ok(Ok(()))) {
            warn!(spans = self.0.queued.load(Ordering::Acquire), "the last traces have not reached the collector");
        }
    }
}

/// The queue, and the thread that empties it.
fn processor(exporter: impl SpanExporter + 'static) -> BatchSpanProcessor {
    let batches = BatchConfigBuilder::default()
        .with_max_queue_size(QUEUE_SPANS)
        .with_max_export_batch_size(BATCH_SPANS)
        .with_scheduled_delay(SEND_EVERY)
        .build();
    BatchSpanProcessor::new(exporter, batches)
}

#[cfg(test)]
mod tests;
