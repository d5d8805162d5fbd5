//! The metrics of a fleet: each is declared in one line below, and nowhere else.

use prometheus::{Gauge, Histogram, IntCounter, IntGauge, Registry, Result};

use super::kinds::{Buckets, Counters, Gauges, Histograms, OfFleet, Quantities};
use super::labels;

/// 0.20385 and 0.3618 are what the paper measured for its cases 1 and 2.
const ERROR_RATIOS: Buckets = &[0.02, 0.05, 0.1, 0.15, 0.20385, 0.25, 0.3, 0.3618, 0.5, 0.75, 1.0];
const COMMIT_SECONDS: Buckets = &[0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 5.0];
const LAG_SECONDS: Buckets = &[0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 60.0];
const SETPOINT_SECONDS: Buckets = &[0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0];
const CONTACTS: Buckets = &[2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0];

/// Spells out what is declared and what a fleet is given of it, so that neither can have what the other has not.
macro_rules! of_fleet {
    ($($(#[doc = $doc:literal])+ $field:ident: $kind:ty = $name:literal, $help:literal $(, $shape:expr)?;)+) => {
        /// Every metric that fleets have, declared.
        #[derive(Debug, Clone)]
        pub(super) struct Families {
            $($field: <$kind as OfFleet>::Family,)+
        }

        /// The metrics of one fleet.
        #[derive(Debug, Clone)]
        pub struct FleetMetrics {
            $($(#[doc = $doc])+ pub $field: $kind,)+
        }

        impl Families {
            pub(super) fn declare(registry: &Registry) -> Result<Self> {
                Ok(Self { $($field: <$kind>::register(registry, $name, $help, ($($shape)?))?,)+ })
            }

            pub(super) fn of(&self, fleet: &str) -> FleetMetrics {
                FleetMetrics { $($field: OfFleet::of(&self.$field, fleet, ($($shape)?)),)+ }
            }
        }
    };
}

of_fleet! {
    /// Messages received, by topic.
    messages_received: Counters = "vibrissa_messages_received_total", "Messages received from robots.", labels::TOPIC;
    /// Messages, or contacts of a message, refused, by reason.
    messages_refused: Counters = "vibrissa_messages_refused_total",
        "Messages, or contacts of a message, refused by the supervisor.", labels::REASON;
    /// Contacts messages that had been seen before.
    messages_duplicate: IntCounter = "vibrissa_messages_duplicate_total",
        "Contacts messages that had been seen before.";
    /// Contacts messages that filled a gap.
    messages_resent: IntCounter = "vibrissa_messages_resent_total",
        "Contacts messages that filled a gap: sent again, or overtaken.";
    /// Contacts messages not taken in because the inbox was full; robots send them again.
    messages_shed: IntCounter = "vibrissa_messages_shed_total",
        "Contacts messages not taken in because the inbox was full; robots send them again.";
    /// Those of them whose robot held more than its share of the inbox.
    messages_shed_over_share: IntCounter = "vibrissa_messages_shed_over_share_total",
        "Contacts messages not taken in because their robot held more than its share of the inbox; they count as shed, too.";
    /// Contacts messages that are not waited for any more: their robot does not send them again.
    messages_given_up: IntCounter = "vibrissa_messages_given_up_total",
        "Contacts messages not waited for any more: lost.";
    /// Messages that the database refuses for good, by cause.
    messages_quarantined: Counters = "vibrissa_messages_quarantined_total",
        "Messages put into quarantine because the database refuses the rows that they lead to.", labels::REJECTION_CAUSE;
    /// Robots whose messages are tried few at a time, because the database has refused rows of theirs in the last minute.
    robots_suspect: IntGauge = "vibrissa_robots_suspect",
        "Robots of which the database has refused rows within the last minute: their messages are committed few at a time.";
    /// Contacts taken, by what they were used for.
    contacts: Counters = "vibrissa_contacts_total", "Contacts taken, by what they were used for.", labels::USED;
    /// Receipts sent.
    receipts_sent: IntCounter = "vibrissa_receipts_sent_total", "Receipts sent to robots.";
    /// Publications dropped because the broker was away; they are made again.
    publications_dropped: IntCounter = "vibrissa_publications_dropped_total",
        "Publications dropped because the broker was away or the lease had run out; they are made again.";
    /// From the newest contact of a message, by the robot's clock, to its commit.
    contact_to_commit_seconds: Histogram = "vibrissa_contact_to_commit_seconds",
        "From the newest contact of a message, by the robot's clock, to its commit.", LAG_SECONDS;
    /// From the receipt of a contacts message to its commit.
    received_to_commit_seconds: Histogram = "vibrissa_received_to_commit_seconds",
        "From the receipt of a contacts message to its commit.", LAG_SECONDS;
    /// When a contacts message was received last, or else the fleet was taken up here, since 1970 UTC; 0 elsewhere.
    last_contact_timestamp_seconds: Gauge = "vibrissa_last_contact_timestamp_seconds",
        "When a contacts message was received last, or else the fleet was taken up here, since 1970 UTC; 0 elsewhere.";
    /// What waits, by queue.
    queue_messages: Gauges = "vibrissa_queue_messages", "Messages that wait, by queue.", labels::QUEUE;
    /// What may wait, by queue.
    queue_capacity_messages: Gauges = "vibrissa_queue_capacity_messages",
        "Messages that may wait, by queue; beyond that they are left out.", labels::QUEUE;
    /// Bytes that wait in the inbox.
    inbox_bytes: IntGauge = "vibrissa_inbox_bytes", "Bytes that wait in the inbox.";
    /// Bytes that may wait there.
    inbox_capacity_bytes: IntGauge = "vibrissa_inbox_capacity_bytes", "Bytes that may wait in the inbox.";

    /// Robots, by connection.
    robots: Gauges = "vibrissa_robots", "Robots, by connection.", labels::CONNECTION;
    /// Whiskers, by fault or else condition.
    whiskers: Gauges = "vibrissa_whiskers", "Whiskers, by fault or else condition.", labels::HEALTH;
    /// Trims found.
    trims: IntCounter = "vibrissa_trims_total", "Trims found.";
    /// Contacts from the likeliest moment of a cut to the decision that it is one.
    trim_detection_contacts: Histogram = "vibrissa_trim_detection_contacts",
        "Contacts of a whisker from the likeliest moment of a cut to the decision that it is one.", CONTACTS;
    /// Compensations, by case and by each outcome that they came to.
    compensations: Counters<2> = "vibrissa_compensations_total",
        "Compensations, by case of the paper and by each outcome that they came to.", labels::CASE_AND_OUTCOME;
    /// Compensations in force, by case.
    compensations_in_force: Gauges = "vibrissa_compensations_in_force",
        "Compensations in force, by case; those that wait for approval are not.", labels::CASE;
    /// Measured compensation errors as they were stated, by case.
    compensation_error_ratio: Histograms = "vibrissa_compensation_error_ratio",
        "Measured compensation errors (Eq. 35) as they were stated.", (labels::CASE, ERROR_RATIOS);
    /// Mean over the compensations in force of the error that was measured last.
    compensation_error_mean_ratio: Quantities = "vibrissa_compensation_error_mean_ratio",
        "Mean over the compensations in force of the error (Eq. 35) measured last.", labels::CASE;
    /// The largest of these.
    compensation_error_worst_ratio: Quantities = "vibrissa_compensation_error_worst_ratio",
        "Largest error (Eq. 35) measured last among the compensations in force.", labels::CASE;
    /// The same mean with the published gains applied.
    compensation_error_with_gain_mean_ratio: Quantities = "vibrissa_compensation_error_with_gain_mean_ratio",
        "Mean over the compensations in force of the error measured last, with the published gain applied.", labels::CASE;
    /// Mean of what was predicted for these compensations.
    compensation_predicted_error_mean_ratio: Quantities = "vibrissa_compensation_predicted_error_mean_ratio",
        "Mean over the compensations in force of the error that was predicted when they were decided.", labels::CASE;
    /// The policy's limit on predicted errors.
    compensation_error_limit_ratio: Gauge = "vibrissa_compensation_error_limit_ratio",
        "The policy's highest predicted error of a compensation.";
    /// Looks at setpoints, by what came of them.
    refinements: Counters = "vibrissa_refinements_total",
        "Looks at the setpoint of a compensation, by what came of them.", labels::REFINEMENT;

    /// Setpoints, by each state that they came into.
    setpoints: Counters = "vibrissa_setpoints_total", "Setpoints, by each state that they came into.", labels::STATE;
    /// Setpoints that a robot refused, by its reason.
    setpoints_rejected: Counters = "vibrissa_setpoints_rejected_total",
        "Setpoints that robots refused, by their reason.", labels::REJECTION;
    /// Setpoints that were too old to go out.
    setpoints_expired_unsent: IntCounter = "vibrissa_setpoints_expired_unsent_total",
        "Setpoints not sent, or not sent again, because their time to live was over by the monotonic clock.";
    /// Setpoints sent again because they were not answered.
    setpoints_resent: IntCounter = "vibrissa_setpoints_resent_total",
        "Setpoints published once more because no answer came.";
    /// Setpoints without a final answer.
    setpoints_under_way: IntGauge = "vibrissa_setpoints_under_way", "Setpoints without a final answer yet.";
    /// From the receipt of what led to a setpoint to its publication.
    setpoint_publication_seconds: Histograms = "vibrissa_setpoint_publication_seconds",
        "From the receipt of the message that led to a setpoint to its publication.",
        (labels::SETPOINT_REASON, SETPOINT_SECONDS);
    /// From the receipt of what led to a setpoint to the robot's word that it is applied.
    setpoint_application_seconds: Histograms = "vibrissa_setpoint_application_seconds",
        "From the receipt of the message that led to a setpoint to the robot's answer that it is applied.",
        (labels::SETPOINT_REASON, SETPOINT_SECONDS);

    /// Alarms raised, by kind.
    alarms_raised: Counters = "vibrissa_alarms_raised_total", "Alarms raised.", labels::ALARM;
    /// Alarms that stand, by kind.
    alarms_standing: Gauges = "vibrissa_alarms_standing", "Alarms that stand.", labels::ALARM;
    /// What operators asked, by kind and by what became of it.
    actions: Counters<2> = "vibrissa_actions_total", "What operators asked, by what became of it.", labels::ACTION;

    /// Time of a commit.
    database_commit_seconds: Histogram = "vibrissa_database_commit_seconds", "Time of a commit.", COMMIT_SECONDS;
    /// 1 while the fleet's messages are received.
    broker_connected: IntGauge = "vibrissa_broker_connected",
        "1 while the fleet's messages are received from the broker, as probes prove.";
    /// Connections made to the broker on which the fleet's messages are received.
    broker_connections: IntCounter = "vibrissa_broker_connections_total",
        "Connections made to the broker on which the fleet's messages are received.";
    /// Connections that the broker ended because another client connected with their client id.
    mqtt_session_takeovers: IntCounter = "vibrissa_mqtt_session_takeovers_total",
        "Connections that the broker ended because another client connected with their client id.";
    /// Connections that the broker closed alone, without a reason.
    mqtt_connections_closed: IntCounter = "vibrissa_mqtt_connections_closed_total",
        "Connections that the broker closed without a reason while the fleet's other one stood; some brokers do so after a takeover.";
    /// Probes that did not come back in time, by topic.
    mqtt_probe_failures: Counters = "vibrissa_mqtt_probe_failures_total",
        "Probes that the supervisor sent to itself and that did not come back in time, by topic.", labels::TOPIC;
    /// From the sending of the newest probes to their return.
    mqtt_probe_round_trip_seconds: Gauge = "vibrissa_mqtt_probe_round_trip_seconds",
        "From the sending of the newest probes through the broker to the return of the last of them.";
    /// 1 while the fleet is supervised here.
    lease_held: IntGauge = "vibrissa_lease_held", "1 while the fleet is supervised here.";
    /// The epoch in which it was supervised here last.
    lease_epoch: IntGauge = "vibrissa_lease_epoch",
        "The epoch in which the fleet was supervised here last: milliseconds since 1970 at its beginning, or more.";
    /// Leases taken, and lost or given back.
    lease_changes: Counters = "vibrissa_lease_changes_total",
        "Times that the fleet was taken up here, and lost or given back.", labels::CHANGE;
    /// 1 for the policy's mode in force.
    policy_mode: Gauges = "vibrissa_policy_mode", "1 for the policy's mode in force.", labels::MODE;
    /// The policy's version in force; 0 for the configuration's.
    policy_version: IntGauge = "vibrissa_policy_version", "The policy's version in force; 0 for the configuration's.";
    /// Mean number of contacts of a healthy whisker between false alarms of the detector (ARL0), in force.
    detector_arl_contacts: Gauge = "vibrissa_detector_arl_contacts",
        "Mean number of contacts of a healthy whisker between false alarms of the detector (ARL0), in force.";
}

impl FleetMetrics {
    /// Those that are shown only while they are known.
    pub(super) fn quantities(&self) -> [&Quantities; 4] {
        [
            &self.compensation_error_mean_ratio,
            &self.compensation_error_worst_ratio,
            &self.compensation_error_with_gain_mean_ratio,
            &self.compensation_predicted_error_mean_ratio,
        ]
    }

    /// Says that nothing is known of the fleet here any more.
    pub fn forget(&self) {
        let none = |_| 0;
        for gauges in [
            &self.robots,
            &self.whiskers,
            &self.alarms_standing,
            &self.compensations_in_force,
            &self.queue_messages,
            &self.policy_mode,
        ] {
            gauges.set_all(none);
        }
        for quantities in self.quantities() {
            quantities.set_all(|_| None);
        }
        for gauge in [&self.setpoints_under_way, &self.inbox_bytes, &self.broker_connected, &self.robots_suspect] {
            gauge.set(0);
        }
        for gauge in [
            &self.last_contact_timestamp_seconds,
            &self.compensation_error_limit_ratio,
            &self.mqtt_probe_round_trip_seconds,
        ] {
            gauge.set(0.0);
        }
    }
}
