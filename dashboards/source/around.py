"""Panels about the supervisors' surroundings: database, broker, Kafka, archive, leases, setpoints, HTTP, processes."""

from grafana_foundation_sdk.models.prometheus import PromQueryFormat

from .grafana import Sql, by_name, hidden, promql
from .panels import heatmap, table, timeseries
from .rows import of_fleets, time
from .series import any_of, buckets, largest, lately, mean, of_all, of_fleet, per_second, quantile, rate, shares, total


def database():
    commit = "vibrissa_database_commit_seconds"
    return [
        heatmap("Commits", "Duration of transactions.", "s", promql(buckets(of_fleet, commit), "{{le}}")),
        timeseries(
            "Commit times",
            "Mean and quantiles of recent commits.",
            "s",
            [promql(mean(of_fleet, commit), "mean")] + shares(of_fleet, commit),
            size=(12, 8),
        ),
        timeseries(
            "Commits per second",
            "Each commit writes the contacts, decisions, setpoints and states of some milliseconds.",
            "cps",
            [promql(total(rate(of_fleet(commit + "_count")), "fleet"), "{{fleet}}")],
        ),
        timeseries(
            "Database",
            "1 if the last access of a supervisor succeeded, and failed accesses per second.",
            "none",
            [
                promql(largest(of_all("vibrissa_database_up"), "instance"), "{{instance}} up"),
                promql(total(rate(of_all("vibrissa_database_errors_total")), "instance"), "{{instance}} errors"),
            ],
        ),
        timeseries(
            "Broker",
            "1 while a fleet's messages are received, and new connections per minute.",
            "none",
            [
                promql(largest(of_fleet("vibrissa_broker_connected"), "fleet"), "{{fleet}} connected"),
                promql(
                    f"60 * {total(rate(of_fleet('vibrissa_broker_connections_total')), 'fleet')}",
                    "{{fleet}} connections",
                ),
            ],
        ),
    ]


def engines():
    # The newest position: former owners have an older one.
    behind = f"time() - {largest(of_fleet('vibrissa_archive_position_timestamp_seconds') + ' > 0', 'fleet')}"
    skipped = total(lately(of_fleet("vibrissa_kafka_records_skipped_total")), "fleet, reason")
    published = per_second("vibrissa_kafka_events_published_total", "fleet")
    return [
        timeseries(
            "Records not read yet",
            "Records of contacts and statuses in Kafka that the owners have not read (ingest by Kafka).",
            "none",
            [promql(total(of_fleet("vibrissa_kafka_lag_records"), "fleet"), "{{fleet}}")],
        ),
        timeseries(
            "Events that wait",
            "Transactions whose events Kafka has not taken yet (publication by Kafka). They wait in the database.",
            "none",
            [promql(total(of_fleet("vibrissa_kafka_outbox_events"), "fleet"), "{{fleet}}")],
        ),
        timeseries(
            "Events published",
            "Events that Kafka has acknowledged, per second.",
            "cps",
            [promql(published, "{{fleet}}")],
        ),
        timeseries(
            "Records skipped",
            "Records of Kafka in the panel's interval that are no contacts or status of the fleet, by reason.",
            "none",
            [promql(any_of(skipped, "fleet", "reason"), "{{fleet}} {{reason}}")],
            bars=True,
        ),
        timeseries(
            "Archive behind",
            "Time since the receipt of the newest contact in the archive of a fleet.",
            "s",
            [promql(any_of(behind, "fleet"), "{{fleet}}")],
        ),
        timeseries(
            "Contacts archived",
            "Contacts written to the archive per second.",
            "cps",
            [promql(per_second("vibrissa_archive_contacts_total", "fleet"), "{{fleet}}")],
        ),
    ]


def ownership():
    held = promql(largest(of_fleet("vibrissa_lease_held"), "fleet, instance"), "{{fleet}} by {{instance}}")
    mode = promql(largest(of_fleet("vibrissa_policy_mode"), "fleet, mode") + " == 1", "{{fleet}}: {{mode}}")
    version = promql(largest(of_fleet("vibrissa_policy_version"), "fleet"), "{{fleet}}: version")
    changes = total(lately(of_fleet("vibrissa_lease_changes_total")), "fleet, instance, change")
    return [
        timeseries("Leases", "1 for the supervisor that holds the lease of a fleet.", "none", [held]),
        timeseries(
            "Epochs",
            "Beginning of the newest epoch of a fleet, which is also its number (milliseconds since 1970). Each change"
            " of owner begins an epoch; epochs order setpoints.",
            "dateTimeAsIso",
            [promql(largest(of_fleet("vibrissa_lease_epoch"), "fleet"), "{{fleet}}")],
        ),
        timeseries(
            "Policies",
            "Whether compensations start at once (AUTOMATIC) or are proposed (ADVISE), and the policy's version; 0 is"
            " the configuration's policy.",
            "none",
            [mode, version],
        ),
        table(
            "Owners",
            "Owner of each fleet, and expiry of its lease.",
            Sql(OWNERS),
            [by_name("until", unit="dateTimeFromNow")],
            (12, 8),
        ),
        table("Epochs", "Owners up to the end of the selected time, newest first.", Sql(EPOCHS), [], (12, 8)),
        timeseries(
            "Changes of leases",
            "Leases acquired and lost in the panel's interval.",
            "none",
            [promql(changes, "{{fleet}} {{change}} by {{instance}}")],
            size=(24, 6),
            bars=True,
        ),
    ]


def outgoing():
    publication = lambda share: promql(
        quantile(share, of_fleet, "vibrissa_setpoint_publication_seconds", by="reason"),
        f"{{{{reason}}}} {100 * share:g} %",
    )
    actions = total(lately(of_fleet("vibrissa_actions_total")), "kind, state")
    rejected = f"60 * {per_second('vibrissa_setpoints_rejected_total', 'error')}"
    return [
        timeseries(
            "Time to publication of a setpoint",
            "From the message that led to a setpoint to its publication, which follows the commit.",
            "s",
            [publication(0.5), publication(0.99)],
        ),
        timeseries(
            "Setpoints rejected by robots",
            "Rejected setpoints per minute by the robot's error code.",
            "cpm",
            [promql(any_of(rejected, "error"), "{{error}}")],
            bars=True,
            stacked=True,
        ),
        timeseries(
            "Actions of operators",
            "Actions in the panel's interval by kind and outcome.",
            "none",
            [promql(any_of(actions, "kind", "state"), "{{kind}} {{state}}")],
            bars=True,
            stacked=True,
        ),
    ]


def http():
    by_route = (
        "histogram_quantile(0.95, "
        + total(rate(of_all("vibrissa_http_request_seconds_bucket")), "le, method, route")
        + ") >= 0"
    )
    return [
        timeseries(
            "Requests by route",
            "Requests per second.",
            "reqps",
            [promql(total(rate(of_all("vibrissa_http_requests_total")), "method, route"), "{{method}} {{route}}")],
            stacked=True,
        ),
        timeseries(
            "Requests by status",
            "Requests per second.",
            "reqps",
            [promql(total(rate(of_all("vibrissa_http_requests_total")), "status"), "{{status}}")],
            stacked=True,
        ),
        timeseries(
            "Response time",
            "95 % of the requests were answered within this time; live streams are not included.",
            "s",
            [promql(by_route, "{{method}} {{route}}")],
        ),
        timeseries(
            "Live streams",
            "Open streams of live events.",
            "none",
            [promql(total(of_all("vibrissa_http_streams"), "instance"), "{{instance}}")],
            size=(24, 6),
        ),
    ]


def processes():
    files = f"{of_all('process_open_fds')} / {of_all('process_max_fds')}"
    violations = total(lately(of_all("vibrissa_invariant_violations_total")), "instance, invariant")
    info = table(
        "Programs",
        "Program version, database and broker of each supervisor.",
        promql(of_all("vibrissa_build_info"), "{{supervisor}}").format(PromQueryFormat.TABLE).instant(),
        hidden("Time", "Value", "__name__", "job"),
        (24, 6),
    )
    each = lambda expression: [promql(expression, "{{instance}}")]
    return [
        timeseries(
            "CPU",
            "CPU time per second: 100 % is one core.",
            "percentunit",
            each(rate(of_all("process_cpu_seconds_total"))),
        ),
        timeseries("Memory", "Resident memory.", "bytes", each(of_all("process_resident_memory_bytes"))),
        timeseries("Files and connections", "Open file descriptors / their limit.", "percentunit", each(files)),
        timeseries("Threads", "Threads of the process.", "none", each(of_all("process_threads"))),
        timeseries(
            "Up for",
            "Time since the process started.",
            "dtdurations",
            each(f"time() - {of_all('process_start_time_seconds')}"),
        ),
        timeseries(
            "Violated invariants",
            "Violations of what must always hold, by supervisor and invariant: each is a defect.",
            "none",
            [promql(any_of(violations, "instance", "invariant"), "{{instance}} {{invariant}}")],
            bars=True,
        ),
        info,
    ]


OWNERS = f"""
    SELECT l.fleet, l.holder, l.epoch, l.commits, {time("l.expires_us")} AS until FROM leases l
    WHERE {of_fleets("l.fleet")} ORDER BY l.fleet
"""

# At most one row for each change of owner.
EPOCHS = f"""
    SELECT e.fleet, e.epoch, e.holder, to_timestamp(e.began_us / 1e6) AS began FROM epochs e
    WHERE {of_fleets("e.fleet")} AND e.began_us <= $__unixEpochNanoTo() / 1000
    ORDER BY e.began_us DESC LIMIT 100
"""
