"""The supervisors themselves: messages, latency, queues, and their surroundings."""

from . import variables
from .around import database, engines, http, outgoing, ownership, processes
from .grafana import promql
from .layout import whole
from .panels import heatmap, stat, timeseries
from .series import (
    any_of,
    buckets,
    gained,
    largest,
    least,
    of_all,
    of_fleet,
    per_second,
    quantile,
    shares,
    total,
)

NAME = "supervisor"


def dashboard():
    """The dashboard."""
    return whole(
        "vibrissa-supervisor",
        "The supervisors themselves: messages, lag, receipts, queues, database, broker, Kafka, archive, ownership,"
        " HTTP, processes.",
        variables.sources() + variables.console() + variables.supervisors() + variables.fleets(),
        [
            ("Now", now()),
            ("Messages in", messages()),
            ("Lag", lag()),
            ("Queues", queues()),
            ("Database and broker", database()),
            ("Kafka and archive", engines()),
            ("Ownership", ownership()),
            ("Setpoints and actions", outgoing()),
            ("HTTP", http()),
            ("Processes", processes()),
        ],
    )


def now():
    missing = [(None, "red"), (1, "green")]
    return [
        stat(
            "Supervisors",
            "Supervisors that are scraped.",
            "none",
            promql(f"count({of_all('vibrissa_build_info')})", "supervisors"),
            missing,
        ),
        stat(
            "Fleets supervised",
            "Share of the fleets whose lease a supervisor holds.",
            "percentunit",
            promql(f"avg({largest(of_fleet('vibrissa_lease_held'), 'fleet')})", "held"),
            missing,
        ),
        stat(
            "Recorded",
            "Time for which the oldest message has waited for its commit.",
            "s",
            promql(largest(of_fleet("vibrissa_promise_age_seconds", 'promise="COMMITTED"')), "oldest"),
            [(None, "green"), (10, "orange"), (60, "red")],
        ),
        stat(
            "Broker",
            "Whether every owned fleet is received from its broker.",
            "bool_yes_no",
            promql(
                least(f"({of_fleet('vibrissa_broker_connected')} and {of_fleet('vibrissa_lease_held')} == 1)"),
                "connected",
            ),
            missing,
        ),
        stat(
            "Contact to commit",
            "99 % of the messages were committed within this time after their newest contact, by the robots' clocks.",
            "s",
            promql(quantile(0.99, of_fleet, "vibrissa_contact_to_commit_seconds"), "99 %"),
        ),
        stat(
            "Lost",
            "Contacts messages given up in the selected time.",
            "none",
            promql(total(gained(of_fleet("vibrissa_messages_given_up_total"))), "lost").instant(),
            [(None, "green"), (0.5, "red")],
        ).decimals(0),
    ]


def messages():
    sent_again = [
        promql(per_second("vibrissa_messages_duplicate_total"), "duplicates"),
        promql(per_second("vibrissa_messages_resent_total"), "filled a gap"),
        promql(per_second("vibrissa_messages_shed_total"), "shed"),
        promql(per_second("vibrissa_messages_given_up_total"), "given up"),
    ]
    published = [
        promql(per_second("vibrissa_receipts_sent_total"), "receipts"),
        promql(per_second("vibrissa_publications_dropped_total"), "dropped, broker unreachable"),
    ]
    return [
        timeseries(
            "Messages by topic",
            "Messages received per second.",
            "cps",
            [promql(per_second("vibrissa_messages_received_total", "topic"), "{{topic}}")],
            stacked=True,
        ),
        timeseries(
            "Contacts by use",
            "Contacts per second by their use.",
            "cps",
            [promql(per_second("vibrissa_contacts_total", "used"), "{{used}}")],
            stacked=True,
        ),
        timeseries(
            "Refused by reason",
            "Messages per second that violate the contract or exceed a limit.",
            "cps",
            [promql(any_of(per_second("vibrissa_messages_refused_total", "reason"), "reason"), "{{reason}}")],
            bars=True,
            stacked=True,
        ),
        timeseries(
            "Duplicates, gaps, losses",
            "Contacts messages per second that were duplicates, filled a gap, were shed, or were given up.",
            "cps",
            sent_again,
            size=(12, 8),
        ),
        timeseries(
            "Published",
            "Receipts per second, and publications dropped without a broker; they are generated again.",
            "cps",
            published,
            size=(12, 8),
        ),
    ]


def lag():
    contact, received = "vibrissa_contact_to_commit_seconds", "vibrissa_received_to_commit_seconds"
    silence = f"time() - {largest(of_fleet('vibrissa_last_contact_timestamp_seconds') + ' > 0', 'fleet')}"
    return [
        heatmap(
            "From contact to commit",
            "From the newest contact of a message, by the robot's clock, to its commit. Includes the time for which the"
            " robot collects contacts.",
            "s",
            promql(buckets(of_fleet, contact), "{{le}}"),
        ),
        heatmap(
            "From received to commit",
            "The supervisor's part of this time, by its own clock.",
            "s",
            promql(buckets(of_fleet, received), "{{le}}"),
        ),
        timeseries(
            "From contact to commit, quantiles", "For recently committed messages.", "s", shares(of_fleet, contact)
        ),
        timeseries(
            "From received to commit, quantiles", "For recently committed messages.", "s", shares(of_fleet, received)
        ),
        timeseries("Silence", "Time since a fleet's last contacts message.", "s", [promql(silence, "{{fleet}}")]),
    ]


def queues():
    fill = (
        f"{largest(of_fleet('vibrissa_queue_messages'), 'fleet, queue')} /"
        f" {largest(of_fleet('vibrissa_queue_capacity_messages'), 'fleet, queue')}"
    )
    full = (
        f"{largest(of_fleet('vibrissa_inbox_bytes'), 'fleet')} /"
        f" {largest(of_fleet('vibrissa_inbox_capacity_bytes'), 'fleet')}"
    )
    return [
        timeseries(
            "Queue usage",
            "Messages in a queue as a share of its capacity: a full inbox sheds contacts.",
            "percentunit",
            [promql(fill, "{{fleet}} {{queue}}")],
        ),
        timeseries(
            "Inbox usage by size",
            "Bytes in the inbox as a share of its capacity.",
            "percentunit",
            [promql(full, "{{fleet}}")],
        ),
        timeseries(
            "Inbox size",
            "Bytes in the inbox.",
            "bytes",
            [promql(largest(of_fleet("vibrissa_inbox_bytes"), "fleet"), "{{fleet}}")],
        ),
    ]
