//! The subjects by which `docs/metrics.md` groups the metrics, each with example queries.

/// A group of metrics.
#[derive(Debug)]
pub(super) struct Subject {
    /// Heading in the document.
    pub(super) title: &'static str,
    /// Beginnings of the names of its metrics; the longest beginning decides.
    pub(super) begins: &'static [&'static str],
    /// Example queries: what each tells, and its PromQL.
    pub(super) queries: &'static [(&'static str, &'static str)],
}

/// All subjects, in the order of the document.
pub(super) const SUBJECTS: &[Subject] = &[
    Subject {
        title: "Robots and whiskers",
        begins: &[
            "vibrissa_robots",
            "vibrissa_robot_",
            "vibrissa_whisker",
            "vibrissa_contacts_",
            "vibrissa_last_contact_",
        ],
        queries: &[
            (
                "Share of healthy whiskers by fleet",
                r#"sum by (fleet) (vibrissa_whiskers{health="HEALTHY"}) / sum by (fleet) (vibrissa_whiskers)"#,
            ),
            (
                "Robots that are not connected, or not heard",
                r#"sum by (fleet) (vibrissa_robots{connection!="ONLINE"})"#,
            ),
            (
                "Share of the contacts that estimates use",
                r#"sum by (fleet) (rate(vibrissa_contacts_total{used="USED"}[5m])) / sum by (fleet) (rate(vibrissa_contacts_total[5m]))"#,
            ),
            (
                "Seconds since the last contacts of a fleet",
                "time() - max by (fleet) (vibrissa_last_contact_timestamp_seconds > 0)",
            ),
        ],
    },
    Subject {
        title: "Alarms",
        begins: &["vibrissa_alarms_", "vibrissa_black_boxes_"],
        queries: &[
            ("Standing alarms by kind", "sum by (fleet, kind) (vibrissa_alarms_standing) > 0"),
            ("Silent robots", r#"sum by (fleet) (vibrissa_alarms_standing{kind="ROBOT_SILENT"})"#),
            ("Alarms raised in the last hour", "sum by (fleet, kind) (increase(vibrissa_alarms_raised_total[1h])) > 0"),
        ],
    },
    Subject {
        title: "Detection of trims",
        begins: &["vibrissa_trim", "vibrissa_detector_", "vibrissa_touch_tests_", "vibrissa_missed_touches_"],
        queries: &[
            ("Trims of the last day", "sum by (fleet) (increase(vibrissa_trims_total[1d]))"),
            (
                "Contacts to detect a trim, 95 % of them",
                "histogram_quantile(0.95, sum by (fleet, le) (increase(vibrissa_trim_detection_contacts_bucket[1d])))",
            ),
        ],
    },
    Subject {
        title: "Compensations",
        begins: &["vibrissa_compensation", "vibrissa_refinements_", "vibrissa_policy_", "vibrissa_rollout_"],
        queries: &[
            ("Compensations in force by case", "sum by (fleet, case) (vibrissa_compensations_in_force)"),
            (
                "Worst measured error by case, beside the policy's limit",
                "max by (fleet, case) (vibrissa_compensation_error_worst_ratio) > on (fleet) group_left () max by (fleet) (vibrissa_compensation_error_limit_ratio)",
            ),
            (
                "Trims in the last day that none can compensate for",
                r#"sum by (fleet) (increase(vibrissa_compensations_total{outcome="UNSERVED"}[1d]))"#,
            ),
            (
                "Roll-outs of the last day whose errors were worse, or that people rolled back",
                r#"sum by (fleet) (increase(vibrissa_rollout_events_total{event="ROLLED_BACK"}[1d])) > 0"#,
            ),
        ],
    },
    Subject {
        title: "Setpoints and operators' actions",
        begins: &["vibrissa_setpoint", "vibrissa_actions_"],
        queries: &[
            (
                "Share of the setpoints that came to nothing",
                r#"sum by (fleet) (increase(vibrissa_setpoints_total{state=~"REJECTED|FAILED|EXPIRED"}[1h])) / sum by (fleet) (increase(vibrissa_setpoints_total{state=~"APPLIED|REJECTED|FAILED|EXPIRED"}[1h]))"#,
            ),
            (
                "Seconds from a message to the applied setpoint, 95 % of them",
                "histogram_quantile(0.95, sum by (fleet, le) (rate(vibrissa_setpoint_application_seconds_bucket[1h])))",
            ),
        ],
    },
    Subject {
        title: "Messages and the broker",
        begins: &[
            "vibrissa_messages_",
            "vibrissa_promise_",
            "vibrissa_mqtt_",
            "vibrissa_broker_",
            "vibrissa_birth_requests_",
            "vibrissa_publications_",
            "vibrissa_receipts_",
            "vibrissa_received_to_commit_",
            "vibrissa_contact_to_commit_",
            "vibrissa_queue_",
            "vibrissa_inbox_",
        ],
        queries: &[
            ("Messages per second by topic", "sum by (fleet, topic) (rate(vibrissa_messages_received_total[5m]))"),
            (
                "Refused messages by reason",
                "sum by (fleet, reason) (increase(vibrissa_messages_refused_total[1h])) > 0",
            ),
            (
                "Seconds that the oldest message has waited for its commit",
                r#"max by (fleet) (vibrissa_promise_age_seconds{promise="COMMITTED"})"#,
            ),
            (
                "How full the queues are",
                "max by (fleet, queue) (vibrissa_queue_messages / vibrissa_queue_capacity_messages)",
            ),
            (
                "Seconds from contact to commit, 99 % of them",
                "histogram_quantile(0.99, sum by (fleet, le) (rate(vibrissa_contact_to_commit_seconds_bucket[5m])))",
            ),
        ],
    },
    Subject {
        title: "Leases and the database",
        begins: &[
            "vibrissa_lease_",
            "vibrissa_database_",
            "vibrissa_clock_",
            "vibrissa_partitions_",
            "vibrissa_old_rows_",
            "vibrissa_upkeep_",
            "vibrissa_items_set_aside_",
            "vibrissa_rows_set_aside_",
        ],
        queries: &[
            ("Fleets that no supervisor holds", "max by (fleet) (vibrissa_lease_held) == 0"),
            (
                "Seconds of a commit, 99 % of them",
                "histogram_quantile(0.99, sum by (fleet, le) (rate(vibrissa_database_commit_seconds_bucket[5m])))",
            ),
            ("Failed attempts to use the database", "increase(vibrissa_database_errors_total[15m])"),
            (
                "Clocks that disagree with a supervisor's",
                "max by (instance, clock) (abs(vibrissa_clock_ahead_seconds)) > 1",
            ),
        ],
    },
    Subject {
        title: "Archive",
        begins: &["vibrissa_archive_"],
        queries: &[
            (
                "Seconds by which the archive is behind",
                "time() - max by (fleet) (vibrissa_archive_position_timestamp_seconds > 0)",
            ),
            (
                "Bytes per archived contact",
                "sum by (fleet) (increase(vibrissa_archive_bytes_total[1d])) / sum by (fleet) (increase(vibrissa_archive_contacts_total[1d]))",
            ),
        ],
    },
    Subject {
        title: "Webhooks",
        begins: &["vibrissa_webhook_"],
        queries: &[
            ("Seconds that the oldest event has waited", "max(vibrissa_webhook_queue_age_seconds)"),
            (
                "Share of the attempts that failed",
                r#"sum(increase(vibrissa_webhook_attempts_total{outcome!="DELIVERED"}[1h])) / sum(increase(vibrissa_webhook_attempts_total[1h]))"#,
            ),
        ],
    },
    Subject {
        title: "Kafka",
        begins: &["vibrissa_kafka_"],
        queries: &[
            (
                "Records that are not read yet",
                "max by (fleet) (vibrissa_kafka_lag_records) and on (fleet) vibrissa_kafka_ingest == 1",
            ),
            ("Events published per second", "sum by (fleet) (rate(vibrissa_kafka_events_published_total[5m]))"),
            ("Events that wait", "sum by (fleet) (vibrissa_kafka_outbox_events) > 0"),
        ],
    },
    Subject {
        title: "HTTP and traces",
        begins: &["vibrissa_http_", "vibrissa_trace_"],
        queries: &[
            (
                "Share of the requests that fail",
                r#"sum by (instance) (rate(vibrissa_http_requests_total{status=~"5.."}[5m])) / sum by (instance) (rate(vibrissa_http_requests_total[5m]))"#,
            ),
            (
                "Seconds of an answer by route, 95 % of them",
                "histogram_quantile(0.95, sum by (route, le) (rate(vibrissa_http_request_seconds_bucket[5m])))",
            ),
        ],
    },
    Subject {
        title: "The program and its process",
        begins: &["vibrissa_build_info", "vibrissa_invariant_", "process_"],
        queries: &[
            ("Versions that run", "count by (version, database) (vibrissa_build_info)"),
            ("Invariants that were violated in the last day", "increase(vibrissa_invariant_violations_total[1d]) > 0"),
            ("CPU cores in use", "rate(process_cpu_seconds_total[5m])"),
            ("Restarts in the last hour", "changes(process_start_time_seconds[1h])"),
        ],
    },
];

/// The subject of a metric: that with the longest matching beginning.
pub(super) fn subject(metric: &str) -> Option<&'static Subject> {
    let length =
        |one: &Subject| one.begins.iter().filter(|begin| metric.starts_with(*begin)).map(|begin| begin.len()).max();
    SUBJECTS.iter().filter(|one| length(one).is_some()).max_by_key(|one| length(one))
}
