//! The metrics of a fleet. Each one is defined in a single line below.

use prometheus::{Gauge, Histogram, IntCounter, IntGauge, Registry, Result};

use super::invariants::Violations;
use super::kinds::{Buckets, Counters, Gauges, Histograms, OfFleet, Quantities};
use super::labels;
use super::nodes::{NodeFailures, NodeInUse};
use crate::promises::Promises;
use crate::set_aside::Reader;

/// Buckets of compensation errors. 0.20385 and 0.3618 are the errors that the paper measured in its cases 1 and 2.
const ERROR_RATIOS: Buckets = &[0.02, 0.05, 0.1, 0.15, 0.20385, 0.25, 0.3, 0.3618, 0.5, 0.75, 1.0];
const COMMIT_SECONDS: Buckets = &[0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 5.0];
const LAG_SECONDS: Buckets = &[0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 60.0];
const SETPOINT_SECONDS: Buckets = &[0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0];
const CONTACTS: Buckets = &[2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0];

/// Generates the registration of all metrics and the struct with a fleet's metrics from one list, so that they cannot
/// differ.
macro_rules! of_fleet {
    ($($(#[doc = $doc:literal])+ $field:ident: $kind:ty = $name:literal, $help:literal $(, $shape:expr)?;)+) => {
        /// All metrics of fleets, as registered.
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
    /// Refused messages and refused contacts of messages, by reason.
    messages_refused: Counters = "vibrissa_messages_refused_total",
        "Messages, or contacts of messages, that the supervisor refused.", labels::REASON;
    /// Refused contacts and missed touches. The others of their messages were accepted.
    contacts_refused: IntCounter = "vibrissa_contacts_refused_total",
        "Contacts that were refused alone; the others of their messages were accepted.";
    /// Contacts messages that were received before.
    messages_duplicate: IntCounter = "vibrissa_messages_duplicate_total",
        "Contacts messages that were duplicates of earlier ones.";
    /// Contacts messages that arrived after a later one.
    messages_resent: IntCounter = "vibrissa_messages_resent_total",
        "Contacts messages that arrived after later ones: sent again, or overtaken.";
    /// Contacts messages that were shed because the inbox was full. Robots send them again.
    messages_shed: IntCounter = "vibrissa_messages_shed_total",
        "Contacts messages shed because the inbox was full; robots send them again.";
    /// Contacts messages that were shed because their robot exceeded its share of the inbox; `messages_shed` counts
    /// them, too.
    messages_shed_over_share: IntCounter = "vibrissa_messages_shed_over_share_total",
        "Contacts messages shed because their robot exceeded its share of the inbox; also counted as shed.";
    /// Lost contacts messages: their robots do not send them again.
    messages_given_up: IntCounter = "vibrissa_messages_given_up_total",
        "Lost contacts messages: robots do not send them again.";
    /// Messages whose rows the database refused for good, by cause.
    messages_quarantined: Counters = "vibrissa_messages_quarantined_total",
        "Messages put into quarantine because the database refused their rows.", labels::REJECTION_CAUSE;
    /// Items that could not be read and were set aside, by reader.
    items_set_aside: Counters = "vibrissa_items_set_aside_total",
        "Stored or received items that could not be read and were set aside, by reader.", labels::READER;
    /// Robots of which the database refused rows within the last minute. Their messages are committed in small
    /// batches.
    robots_suspect: IntGauge = "vibrissa_robots_suspect",
        "Robots of which the database refused rows within the last minute; their messages are committed few at a time.";
    /// Contacts of accepted messages, by use.
    contacts: Counters = "vibrissa_contacts_total", "Contacts of accepted messages, by use.", labels::USED;
    /// Recorded contacts whose time is far from their robot's clock. Their time is not used.
    contacts_bad_time: IntCounter = "vibrissa_contacts_bad_time_total",
        "Recorded contacts whose time is far from their robot's clock; their time is not used.";
    /// Time of receipt up to which all contacts are archived, s since 1970 UTC; 0 without an archive.
    archive_position_timestamp_seconds: Gauge = "vibrissa_archive_position_timestamp_seconds",
        "Time of receipt up to which all contacts are archived, since 1970 UTC; 0 without an archive or elsewhere.";
    /// Contacts that were archived.
    archive_contacts: IntCounter = "vibrissa_archive_contacts_total", "Contacts written to the archive.";
    /// Bytes of the archived files.
    archive_bytes: IntCounter = "vibrissa_archive_bytes_total", "Bytes of the files written to the archive.";
    /// Failed attempts to write a file of the archive.
    archive_errors: IntCounter = "vibrissa_archive_errors_total", "Failed attempts to write a file of the archive.";
    /// Receipts sent to robots.
    receipts_sent: IntCounter = "vibrissa_receipts_sent_total", "Receipts sent to robots.";
    /// Publications dropped because the broker was unreachable or the lease had expired. They are generated again.
    publications_dropped: IntCounter = "vibrissa_publications_dropped_total",
        "Publications dropped because the broker was unreachable or the lease had expired; they are generated again.";
    /// Time from the newest contact of a message, by the robot's clock, to its commit, s.
    contact_to_commit_seconds: Histogram = "vibrissa_contact_to_commit_seconds",
        "Time from the newest contact of a message, by the robot's clock, to its commit.", LAG_SECONDS;
    /// Time from the receipt of a contacts message to its commit, s.
    received_to_commit_seconds: Histogram = "vibrissa_received_to_commit_seconds",
        "Time from the receipt of a contacts message to its commit.", LAG_SECONDS;
    /// Time of receipt of the last committed contacts message, or else of the acquisition of the fleet, s since 1970
    /// UTC; 0 if the fleet is supervised elsewhere.
    last_contact_timestamp_seconds: Gauge = "vibrissa_last_contact_timestamp_seconds",
        "Time of receipt of the last contacts message, or else of the lease's acquisition; 0 if supervised elsewhere.";
    /// The promises to the robots, and for how long each has been open.
    promises: Promises = "vibrissa_promise_age_seconds",
        "Age of the oldest item for which a promise to robots is open: that a message is received, committed, receipted, \
         that a setpoint is answered; 0 if none is open.";
    /// Waiting messages, by queue.
    queue_messages: Gauges = "vibrissa_queue_messages", "Waiting messages, by queue.", labels::QUEUE;
    /// Capacity in messages, by queue.
    queue_capacity_messages: Gauges = "vibrissa_queue_capacity_messages",
        "Capacity in messages, by queue; further messages are not accepted.", labels::QUEUE;
    /// Size of the messages that wait in the inbox, bytes.
    inbox_bytes: IntGauge = "vibrissa_inbox_bytes", "Size of the messages that wait in the inbox.";
    /// Capacity of the inbox, bytes.
    inbox_capacity_bytes: IntGauge = "vibrissa_inbox_capacity_bytes", "Capacity of the inbox.";

    /// Robots, by connection state; `SILENT` are connected, but not heard.
    robots: Gauges = "vibrissa_robots", "Robots, by connection state; SILENT are connected, but not heard.",
        labels::CONNECTION;
    /// Robots that have announced themselves, and whose factsheets have not arrived, or were refused, for 30 s.
    robots_without_factsheet: IntGauge = "vibrissa_robots_without_factsheet",
        "Robots that announced themselves, and whose factsheets have not arrived, or were refused, for 30 s.";
    /// Whiskers, by fault, or by condition if they have no fault.
    whiskers: Gauges = "vibrissa_whiskers",
        "Whiskers, by fault, or by condition if they have no fault.", labels::HEALTH;
    /// Number of detected trims.
    trims: IntCounter = "vibrissa_trims_total", "Detected trims.";
    /// Contacts of a whisker from the most likely moment of a cut to its detection.
    trim_detection_contacts: Histogram = "vibrissa_trim_detection_contacts",
        "Contacts of a whisker from the most likely moment of a cut to its detection.", CONTACTS;
    /// Events of compensations, by case of the paper and outcome. A compensation counts in each outcome that it
    /// reaches.
    compensations: Counters<2> = "vibrissa_compensations_total",
        "Compensations, by case of the paper and by each outcome that they reached.", labels::CASE_AND_OUTCOME;
    /// Compensations in force, by case of the paper.
    compensations_in_force: Gauges = "vibrissa_compensations_in_force",
        "Compensations in force, by case of the paper; those that wait for approval are not counted.", labels::CASE;
    /// Measured compensation errors (Eq. 35), by case of the paper, as ratios.
    compensation_error_ratio: Histograms = "vibrissa_compensation_error_ratio",
        "Measured compensation errors (Eq. 35), as ratios.", (labels::CASE, ERROR_RATIOS);
    /// Mean of the newest measured error of each compensation in force, by case, as a ratio.
    compensation_error_mean_ratio: Quantities = "vibrissa_compensation_error_mean_ratio",
        "Mean of the newest measured errors (Eq. 35) of the compensations in force.", labels::CASE;
    /// Largest of the newest measured errors of the compensations in force, by case, as a ratio.
    compensation_error_worst_ratio: Quantities = "vibrissa_compensation_error_worst_ratio",
        "Largest of the newest measured errors (Eq. 35) of the compensations in force.", labels::CASE;
    /// Mean of the newest measured errors with the published gains applied, by case, as a ratio.
    compensation_error_with_gain_mean_ratio: Quantities = "vibrissa_compensation_error_with_gain_mean_ratio",
        "Mean of the newest measured errors of the compensations in force, with the published gains applied.",
        labels::CASE;
    /// Mean of the newest measured errors of the air alone, over the compensations whose robots apply a gain, by case, as a
    /// ratio.
    compensation_air_error_mean_ratio: Quantities = "vibrissa_compensation_air_error_mean_ratio",
        "Mean of the newest measured errors of the compensations in force, without the gain that their robots apply.",
        labels::CASE;
    /// Mean predicted error of the compensations in force, by case, as a ratio.
    compensation_predicted_error_mean_ratio: Quantities = "vibrissa_compensation_predicted_error_mean_ratio",
        "Mean predicted error of the compensations in force, as of their decisions.", labels::CASE;
    /// Highest predicted error at which the policy starts a compensation, as a ratio.
    compensation_error_limit_ratio: Gauge = "vibrissa_compensation_error_limit_ratio",
        "Highest predicted error at which the policy starts a compensation.";
    /// Evaluations of setpoints for refinement, by outcome.
    refinements: Counters = "vibrissa_refinements_total",
        "Evaluations of compensations' setpoints for refinement, by outcome.", labels::REFINEMENT;

    /// Setpoints, by state. A setpoint counts in each state that it enters.
    setpoints: Counters = "vibrissa_setpoints_total",
        "Setpoints, by each state that they entered; without those that a robot in a task declined.", labels::STATE;
    /// Setpoints that robots rejected, by reason.
    setpoints_rejected: Counters = "vibrissa_setpoints_rejected_total",
        "Setpoints that robots rejected, by reason.", labels::REJECTION;
    /// Setpoints that were not sent, or not sent again, because they had expired by the monotonic clock.
    setpoints_expired_unsent: IntCounter = "vibrissa_setpoints_expired_unsent_total",
        "Setpoints not sent, or not sent again, because they had expired by the monotonic clock.";
    /// Publications of setpoints that were repeated because no answer came.
    setpoints_resent: IntCounter = "vibrissa_setpoints_resent_total",
        "Repeated publications of setpoints because no answer came.";
    /// Setpoints without a final answer.
    setpoints_under_way: IntGauge = "vibrissa_setpoints_under_way", "Setpoints without a final answer.";
    /// Time from the receipt of the message that caused a setpoint to the setpoint's publication, by reason, s.
    setpoint_publication_seconds: Histograms = "vibrissa_setpoint_publication_seconds",
        "Time from the receipt of the message that caused a setpoint to the setpoint's publication.",
        (labels::SETPOINT_REASON, SETPOINT_SECONDS);
    /// Time from the receipt of the message that caused a setpoint to the robot's answer that it is applied, by
    /// reason, s.
    setpoint_application_seconds: Histograms = "vibrissa_setpoint_application_seconds",
        "Time from the receipt of the message that caused a setpoint to the robot's answer that it is applied.",
        (labels::SETPOINT_REASON, SETPOINT_SECONDS);

    /// Touch tests, by state. A test counts in each state that it enters.
    touch_tests: Counters = "vibrissa_touch_tests_total",
        "Touch tests, by each state that they entered.", labels::TEST_STATE;
    /// Touch tests that were requested or proposed, by reason.
    touch_tests_begun: Counters = "vibrissa_touch_tests_begun_total",
        "Touch tests that were requested or, in mode advise, proposed, by reason.", labels::TEST_REASON;
    /// Touches that robots expected and that did not come.
    missed_touches: IntCounter = "vibrissa_missed_touches_total",
        "Touches that robots expected at a known distance and that did not come.";

    /// Black boxes that could not be written.
    black_boxes_lost: IntCounter = "vibrissa_black_boxes_lost_total",
        "Black boxes that could not be written, because the database was unreachable or too busy.";

    /// Events that the log has acknowledged.
    events_published: IntCounter = "vibrissa_kafka_events_published_total",
        "Events that the log has acknowledged, including repeated ones.";
    /// Rounds of publication that failed. They are repeated.
    event_writes_failed: IntCounter = "vibrissa_kafka_writes_failed_total",
        "Failed attempts to publish the waiting events; they are repeated.";
    /// Events that cannot be published.
    events_lost: IntCounter = "vibrissa_kafka_events_lost_total",
        "Events that the log refuses for good, or that cannot be read from the database.";
    /// Events that wait for the log.
    outbox_events: IntGauge = "vibrissa_kafka_outbox_events",
        "Events that wait in the database because the log does not take them.";
    /// Bytes of events that wait for the log.
    outbox_bytes: IntGauge = "vibrissa_kafka_outbox_bytes",
        "Bytes of the events that wait in the database because the log does not take them.";
    /// Contacts that are not published because too many events wait.
    contacts_left_out: IntCounter = "vibrissa_kafka_contacts_left_out_total",
        "Contacts that are not published because the events that wait have reached kafka.waiting_mib_max.";

    /// 1 while the owner takes contacts from the log, else 0.
    log_ingest: IntGauge = "vibrissa_kafka_ingest",
        "1 while the owner takes contacts from a log, whether it answers or not, else 0.";
    /// 1 while all partitions of the log answer that contacts come from, else 0.
    log_connected: IntGauge = "vibrissa_kafka_connected",
        "1 while all partitions of the log that contacts come from answer; 0 without a log.";
    /// Records of the log that are not stepped yet.
    log_lag: IntGauge = "vibrissa_kafka_lag_records", "Records of all partitions that are not read yet.";
    /// Records of the log that were skipped, by reason.
    log_skipped: Counters = "vibrissa_kafka_records_skipped_total",
        "Records of the log that are no contacts or status of a robot of the fleet, by reason.", labels::LOG_SKIPPED;

    /// Alarms raised, by kind.
    alarms_raised: Counters = "vibrissa_alarms_raised_total", "Alarms raised, by kind.", labels::ALARM;
    /// Standing alarms, by kind.
    alarms_standing: Gauges = "vibrissa_alarms_standing", "Standing alarms, by kind.", labels::ALARM;
    /// Actions of operators, by kind and final state.
    actions: Counters<2> = "vibrissa_actions_total", "Actions of operators, by kind and final state.", labels::ACTION;

    /// Violated invariants of all fleets.
    violations: Violations = "vibrissa_invariant_violations_total",
        "Violations of what always holds, of all fleets, by invariant: each is a defect.";
    /// Duration of a commit, s.
    database_commit_seconds: Histogram = "vibrissa_database_commit_seconds",
        "Duration of a commit to the database.", COMMIT_SECONDS;
    /// 1 while the fleet's messages are received from the broker, else 0.
    broker_connected: IntGauge = "vibrissa_broker_connected",
        "1 while the fleet's messages are received from the broker, as verified by probes.";
    /// Connections to the broker over which the fleet's messages were received.
    broker_connections: IntCounter = "vibrissa_broker_connections_total",
        "Connections to the broker over which the fleet's messages were received.";
    /// Nodes of the broker that the fleet's connections use.
    mqtt_node: NodeInUse = "vibrissa_mqtt_node_in_use",
        "1 for the broker's node that a connection of the fleet uses; no series while the connection is down.";
    /// Failed connections, and failed attempts to connect, by node.
    mqtt_node_failures: NodeFailures = "vibrissa_mqtt_node_failures_total",
        "Connections to a node of the broker that broke, and attempts to connect that failed.";
    /// Connections that the broker closed because another client connected with the same client id.
    mqtt_session_takeovers: IntCounter = "vibrissa_mqtt_session_takeovers_total",
        "Connections that the broker closed because another client connected with the same client id.";
    /// Connections that the broker closed without a reason while the fleet's other connection stayed open.
    mqtt_connections_closed: IntCounter = "vibrissa_mqtt_connections_closed_total",
        "Connections that the broker closed without a reason while the fleet's other one stayed open.";
    /// Probes that did not return in time, by topic.
    mqtt_probe_failures: Counters = "vibrissa_mqtt_probe_failures_total",
        "Probes from the supervisor to itself that did not return in time, by topic.", labels::TOPIC;
    /// Time from the sending of the newest probes to the return of the last of them, s.
    mqtt_probe_round_trip_seconds: Gauge = "vibrissa_mqtt_probe_round_trip_seconds",
        "Time from the sending of the newest probes through the broker to the return of the last of them.";
    /// Requests to all robots for their births and factsheets, by cause.
    birth_requests: Counters = "vibrissa_birth_requests_total",
        "Requests to all robots of the fleet for their births and factsheets, by cause.", labels::BIRTH_CAUSE;

    /// 1 while this supervisor holds the fleet's lease, else 0.
    lease_held: IntGauge = "vibrissa_lease_held", "1 while this supervisor holds the fleet's lease.";
    /// Epoch of this supervisor's newest lease of the fleet.
    lease_epoch: IntGauge = "vibrissa_lease_epoch",
        "Epoch of this supervisor's newest lease of the fleet: milliseconds since 1970 at its begin, or more.";
    /// Leases acquired, and lost or released, by change.
    lease_changes: Counters = "vibrissa_lease_changes_total",
        "Leases of the fleet that this supervisor acquired, and lost or released.", labels::CHANGE;
    /// 1 for the mode of the policy in force, 0 for the others.
    policy_mode: Gauges = "vibrissa_policy_mode", "1 for the mode of the policy in force.", labels::MODE;
    /// Stage of the roll-out that is running or paused: 0 without one, 1 for 5 % of the robots, 2 for 25 %.
    rollout_stage: IntGauge = "vibrissa_rollout_stage",
        "Stage of the fleet's roll-out: 0 without one, 1 for 5 % of the robots, 2 for 25 %.";
    /// Events of roll-outs.
    rollouts: Counters = "vibrissa_rollout_events_total", "Events of roll-outs, by kind.", labels::ROLLOUT_EVENT;
    /// Version of the policy in force; 0 for the policy of the configuration.
    policy_version: IntGauge = "vibrissa_policy_version",
        "Version of the policy in force; 0 for the policy of the configuration.";
    /// Mean number of contacts of a healthy whisker between false alarms of the detector (ARL0), by the parameters in
    /// force.
    detector_arl_contacts: Gauge = "vibrissa_detector_arl_contacts",
        "Mean number of contacts of a healthy whisker between false alarms of the detector in force (ARL0).";
}

impl FleetMetrics {
    /// The gauges whose series exist only while their values are known.
    pub(super) fn quantities(&self) -> [&Quantities; 5] {
        [
            &self.compensation_error_mean_ratio,
            &self.compensation_error_worst_ratio,
            &self.compensation_error_with_gain_mean_ratio,
            &self.compensation_air_error_mean_ratio,
            &self.compensation_predicted_error_mean_ratio,
        ]
    }

    /// Resets the gauges, because this supervisor does not own the fleet any more.
    pub fn forget(&self) {
        self.promises.end();
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
        for gauge in [
            &self.setpoints_under_way,
            &self.inbox_bytes,
            &self.broker_connected,
            &self.robots_suspect,
            &self.robots_without_factsheet,
            &self.outbox_events,
            &self.outbox_bytes,
            &self.log_connected,
            &self.log_ingest,
            &self.log_lag,
            &self.rollout_stage,
        ] {
            gauge.set(0);
        }
        for gauge in [
            &self.last_contact_timestamp_seconds,
            &self.compensation_error_limit_ratio,
            &self.mqtt_probe_round_trip_seconds,
            &self.archive_position_timestamp_seconds,
        ] {
            gauge.set(0.0);
        }
    }
}

impl FleetMetrics {
    /// Counts items that a reader has set aside.
    pub(crate) fn set_aside(&self, reader: Reader, count: u64) {
        self.items_set_aside.of([reader.word()]).inc_by(count);
    }
}
