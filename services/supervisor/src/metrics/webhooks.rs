//! Metrics of webhooks. The queues are those of the whole database: all supervisors report the same.

use prometheus::{Gauge, IntCounterVec, IntGauge, Opts, Registry, Result};

use super::Word;

const DELIVERED: Word = "DELIVERED";
const FAILED: Word = "FAILED";
const DEAD: Word = "DEAD";

/// Metrics of webhooks.
#[derive(Debug, Clone)]
pub struct WebhookMetrics {
    attempts: IntCounterVec,
    waiting: IntGauge,
    dead_letters: IntGauge,
    age_seconds: Gauge,
}

impl WebhookMetrics {
    pub(super) fn declare(registry: &Registry) -> Result<Self> {
        let attempts = Opts::new(
            "vibrissa_webhook_attempts_total",
            "Attempts to deliver an event to a webhook: DELIVERED, FAILED (it is tried again), or DEAD (it is a dead letter \
             now).",
        );
        let attempts = IntCounterVec::new(attempts, &["outcome"])?;
        let waiting = IntGauge::new("vibrissa_webhook_queue_events", "Events that wait for enabled webhooks.")?;
        let dead_letters = IntGauge::new("vibrissa_webhook_dead_letters", "Dead letters of enabled webhooks.")?;
        let age_seconds = Gauge::new(
            "vibrissa_webhook_queue_age_seconds",
            "Age of the oldest event that waits for an enabled webhook; 0 if none waits.",
        )?;
        registry.register(Box::new(attempts.clone()))?;
        registry.register(Box::new(waiting.clone()))?;
        registry.register(Box::new(dead_letters.clone()))?;
        registry.register(Box::new(age_seconds.clone()))?;
        for outcome in [DELIVERED, FAILED, DEAD] {
            attempts.with_label_values(&[outcome]);
        }
        Ok(Self { attempts, waiting, dead_letters, age_seconds })
    }

    /// Counts an event that a target has taken.
    pub fn delivered(&self) {
        self.attempts.with_label_values(&[DELIVERED]).inc();
    }

    /// Counts an attempt that is repeated later.
    pub fn failed(&self) {
        self.attempts.with_label_values(&[FAILED]).inc();
    }

    /// Counts an event that becomes a dead letter.
    pub fn dead(&self) {
        self.attempts.with_label_values(&[DEAD]).inc();
    }

    /// Sets the state of the queues.
    pub fn queue(&self, waiting: i64, dead_letters: i64, age_s: f64) {
        self.waiting.set(waiting);
        self.dead_letters.set(dead_letters);
        self.age_seconds.set(age_s);
    }
}
