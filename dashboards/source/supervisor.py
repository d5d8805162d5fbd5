"""The supervisors themselves: what they take in, how long it takes them, and what they rest on."""

from . import variables
from .around import database, http, outgoing, ownership, processes
from .grafana import heatmap, promql, stat, timeseries
from .layout import whole
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
        "The supervisors themselves: messages, lag, receipts, queues, database, broker, ownership, HTTP, processes.",
        variables.sources() + variables.supervisors() + variables.fleets(),
        [
            ("Now", now()),
            ("Messages in", messages()),
            ("Lag", lag()),
            ("Queues", queues()),
            ("Database and broker", database()),
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
            "Share of the fleets that some supervisor holds.",
            "percentunit",
            promql(f"avg({largest(of_fleet('vibrissa_lease_held'), 'fleet')})", "held"),
            missing,
        ),
        stat(
            "Database",
            "Whether every supervisor's last attempt at the database succeeded.",
            "bool_yes_no",
            promql(least(of_all("vibrissa_database_up")), "up"),
            missing,
        ),
        stat(
            "Broker",
            "Whether every fleet that is held has its broker.",
            "bool_yes_no",
            promql(
                least(f"({of_fleet('vibrissa_broker_connected')} and {of_fleet('vibrissa_lease_held')} == 1)"),
                "connected",
            ),
            missing,
        ),
        stat(
            "Contact to commit",
            "99 % of the messages were recorded within this time after their newest contact, by the robots' clocks.",
            "s",
            promql(quantile(0.99, of_fleet, "vibrissa_contact_to_commit_seconds"), "99 %"),
        ),
        stat(
            "Lost",
            "Contacts messages that are not waited for any more, in this time.",
            "none",
            promql(total(gained(of_fleet("vibrissa_messages_given_up_total"))), "lost", instant=True),
            [(None, "green"), (0.5, "red")],
            defaults={"decimals": 0},
        ),
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
        promql(per_second("vibrissa_publications_dropped_total"), "dropped, broker away"),
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
            "Contacts per second by what they were used for.",
            "cps",
            [promql(per_second("vibrissa_contacts_total", "used"), "{{used}}")],
            stacked=True,
        ),
        timeseries(
            "Refused by reason",
            "Messages per second that break the contract or that there was no room for.",
            "cps",
            [promql(any_of(per_second("vibrissa_messages_refused_total", "reason"), "reason"), "{{reason}}")],
            bars=True,
            stacked=True,
        ),
        timeseries(
            "Duplicates, gaps, losses",
            "Contacts messages per second that were known already, filled a gap, found no room, or are not waited for"
            " any more.",
            "cps",
            sent_again,
            size=(12, 8),
        ),
        timeseries(
            "Published",
            "Receipts per second, and publications that the broker's absence cost: they are made again.",
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
            "From the newest contact of a message, by the robot's clock, until it is recorded: the robot's batches are"
            " in it.",
            "s",
            promql(buckets(of_fleet, contact), "{{le}}", form="heatmap"),
        ),
        heatmap(
            "From received to commit",
            "What of this is the supervisor's, by its own clock.",
            "s",
            promql(buckets(of_fleet, received), "{{le}}", form="heatmap"),
        ),
        timeseries(
            "From contact to commit, quantiles", "Of the messages recorded lately.", "s", shares(of_fleet, contact)
        ),
        timeseries(
            "From received to commit, quantiles", "Of the messages recorded lately.", "s", shares(of_fleet, received)
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
            "Queues' fill",
            "Messages in a queue over those that it has room for: a full inbox sheds contacts.",
            "percentunit",
            [promql(fill, "{{fleet}} {{queue}}")],
        ),
        timeseries(
            "Inbox's fill by size",
            "Bytes in the inbox over those that it has room for.",
            "percentunit",
            [promql(full, "{{fleet}}")],
        ),
        timeseries(
            "Inbox's size",
            "Bytes in the inbox.",
            "bytes",
            [promql(largest(of_fleet("vibrissa_inbox_bytes"), "fleet"), "{{fleet}}")],
        ),
    ]
