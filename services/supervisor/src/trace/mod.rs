//! Traces for OpenTelemetry, if a collector is configured: one trace for each setpoint, from the contact that raised
//! the suspicion to the robot's answer, and one for each HTTP request.
//!
//! A setpoint's trace has the `command_id` as its trace id, so that one is found by the other, and a supervisor that
//! acquires a fleet continues the traces of the last owner. A span is built when its period is over and put into a
//! bounded queue, from which a separate thread sends it: nothing waits for the collector, and spans that it does not
//! accept are dropped and counted. Without a collector there is no thread, no queue and no span.
//!
//! Reading order: `span` (one span), `lifecycle` (a setpoint's trace), `content` (spans and attributes of a step of the
//! core), `request`, `export` (connection to the collector).

mod content;
mod export;
mod lifecycle;
mod request;
mod span;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use opentelemetry::{InstrumentationScope, KeyValue};
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::trace::{BatchConfigBuilder, BatchSpanProcessor, SpanData, SpanExporter, SpanProcessor};
use prometheus::IntCounter;
use tracing::warn;
use vibrissa_host::task;

pub(crate) use content::{Step, TracedAction, is_traced};
pub(crate) use lifecycle::{OpenTraces, PendingSpans};

/// Capacity of the queue in spans; beyond it spans are dropped.
const QUEUE_SPANS: usize = 4096;
/// Largest number of spans in one export.
const BATCH_SPANS: usize = 512;
/// Interval between two exports.
const SEND_EVERY: Duration = Duration::from_secs(1);
/// Time limit for the last export when the service stops.
const STOP_PATIENCE: Duration = Duration::from_secs(2);

/// Destination and sampling of traces.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceOptions {
    /// The collector's URL for traces, usually `http://HOST:4318/v1/traces`.
    pub url: String,
    /// Share of the requests with safe methods (GET) that are traced, 0 to 1; all other requests are always traced.
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

/// Handle of the exporter. Clones share it.
#[derive(Debug, Clone)]
pub struct Traces(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    processor: BatchSpanProcessor,
    scope: InstrumentationScope,
    /// Number of spans in the queue.
    queued: Arc<AtomicUsize>,
    dropped: IntCounter,
    sample_ratio: f64,
    /// The database's name in OpenTelemetry's semantic conventions.
    database: &'static str,
}

impl Traces {
    /// Starts the exporting thread. An unreachable collector is no error: its spans are dropped, and counted in
    /// `dropped`.
    ///
    /// # Errors
    /// The URL is invalid, or the environment variables request an option that is not built in.
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

    /// Puts a span into the queue, or drops it if the queue is full. Never blocks.
    fn submit(&self, span: SpanData) {
        if self.0.queued.fetch_add(1, Ordering::AcqRel) >= QUEUE_SPANS {
            self.0.queued.fetch_sub(1, Ordering::AcqRel);
            self.drop_one();
            return;
        }
        self.0.processor.on_end(span);
    }

    /// Counts a dropped span.
    fn drop_one(&self) {
        self.0.dropped.inc();
    }

    /// Exports the queue within two seconds; later spans are not sent.
    pub async fn stop(&self) {
        let traces = self.clone();
        let stopped = task::blocking(move || traces.0.processor.shutdown_with_timeout(STOP_PATIENCE)).await;
        if !matches!(stopped, Ok(Ok(()))) {
            warn!(spans = self.0.queued.load(Ordering::Acquire), "stopped, last traces not exported");
        }
    }
}

/// The queue, and the thread that exports from it.
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
