//! Stands in for the module `trace` in a build without the feature `traces`: it has the same names, and
//! [`Traces::start`] always fails. [`Traces`] has no value, so no method that takes `self` ever runs.

use std::time::Duration;

use axum::extract::Request;
use axum::http::StatusCode;
use prometheus::IntCounter;
use vibrissa_core::robot::effect::{Command, Effect};
use vibrissa_core::robot::{Event, Robot};
use vibrissa_core::units::Micros;
use vibrissa_protocol::Name;
use vibrissa_store::actions::Action;

use crate::ending::Ending;

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
#[error("this program was built without traces: build it with --features traces, or leave traces.otlp_endpoint out")]
pub struct TraceError;

/// A type without values.
#[derive(Debug, Clone, Copy)]
enum Never {}

/// Handle of the exporter, which does not exist.
#[derive(Debug, Clone)]
pub struct Traces(Never);

impl Traces {
    /// Starts nothing.
    ///
    /// # Errors
    /// Always, because the feature `traces` is not built in.
    pub fn start(_: &TraceOptions, _: &str, _: &'static str, _: IntCounter) -> Result<Self, TraceError> {
        Err(TraceError)
    }

    pub(crate) fn request(&self, _: &Request, _: &str) -> Option<RequestSpan> {
        match self.0 {}
    }

    /// Stops the exporter.
    #[expect(clippy::unused_async, reason = "as in the module that this one stands in for")]
    pub async fn stop(&self) {
        match self.0 {}
    }
}

/// The span of a request.
pub(crate) struct RequestSpan(Never);

impl RequestSpan {
    pub(crate) fn answered(self, _: StatusCode) {
        match self.0 {}
    }
}

/// The open traces of a fleet.
pub(crate) struct OpenTraces(Never);

impl OpenTraces {
    pub(crate) fn new(traces: Traces, _: Name) -> Self {
        match traces.0 {}
    }

    pub(crate) fn take_up(&mut self, _: &Name, _: i64, _: &Robot) {
        match self.0 {}
    }

    pub(crate) fn set_action(&mut self, _: Option<TracedAction>) {
        match self.0 {}
    }

    pub(crate) fn stepped(&mut self, _: &Step<'_>) {
        match self.0 {}
    }

    pub(crate) fn seal(&mut self) -> PendingSpans {
        match self.0 {}
    }

    pub(crate) fn committed(&mut self, _: &mut PendingSpans, _: Duration) {
        match self.0 {}
    }

    pub(crate) fn sending(&mut self, _: &Name, _: &Command) {
        match self.0 {}
    }

    pub(crate) fn published(&mut self, _: PendingSpans, _: Micros, _: bool) {
        match self.0 {}
    }

    pub(crate) fn end(&mut self, _: Ending) {
        match self.0 {}
    }
}

/// Spans that may be exported after a commit: none.
#[derive(Default)]
pub(crate) struct PendingSpans;

/// An operator's action.
#[derive(Clone)]
pub(crate) struct TracedAction;

impl TracedAction {
    pub(crate) fn of(_: &Action) -> Self {
        Self
    }
}

/// A step of the core, with the fields that the module `trace` reads.
#[expect(dead_code, reason = "nothing reads the steps that are not traced")]
pub(crate) struct Step<'a> {
    pub(crate) fleet: &'a Name,
    pub(crate) name: &'a Name,
    pub(crate) robot_id: i64,
    pub(crate) robot: &'a Robot,
    pub(crate) now: Micros,
    pub(crate) event: &'a Event<'a>,
    pub(crate) effects: &'a [Effect],
}

/// Whether a step is traced: none is.
pub(crate) fn is_traced(_: &[Effect]) -> bool {
    false
}
