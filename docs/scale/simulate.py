#!/usr/bin/env python3
"""Simulates a site of robots, brokers, supervisors and a PostgreSQL, and what failures and more robots do to it.

A discrete-event simulation of group commits. docs/scale.md describes the model and has the output. costs.json has the
constants, each with its source. The program needs only Python, and the same seed gives the same output.
"""

import copy
import dataclasses
import heapq
import json
import math
import pathlib
import random

FILE = pathlib.Path(__file__).parent / "costs.json"
COSTS = {name: one["value"] for name, one in json.loads(FILE.read_text()).items()}
US = 1e-6
SEED = 1
COMMIT_EVERY_S = 0.1
# Between two failures; the first one comes after as much time.
BETWEEN_S = 60.0
MINUTE_S = 60.0
# The robot of the benchmark, with one message per second.
CONTACTS, WHISKERS, MESSAGES_PER_S = 20, 10, 1.0
SUPERVISOR, DATABASE = "supervisor killed", "PostgreSQL fails over"
BROKER, KAFKA = "MQTT broker killed", "Kafka broker killed"


@dataclasses.dataclass
class Plan:
    """Engines of a site. Each MQTT broker has one core, as Mosquitto has one thread."""

    robots: int
    fleets: int
    brokers: int
    supervisors: int
    supervisor_cores: int
    database_cores: int
    # 0: PostgreSQL is the journal, and contacts come over MQTT.
    kafka_brokers: int = 0
    kafka_cores: int = 0

    def messages_per_s(self):
        return self.robots * MESSAGES_PER_S

    def contacts_per_s(self):
        return self.messages_per_s() * CONTACTS

    def cost(self, what):
        return COSTS[("log_" if self.kafka_brokers else "mqtt_") + what]

    def per_contact(self):
        """CPU seconds of PostgreSQL and bytes of its log for a contact.

        With Kafka they are those of a checkpoint each minute.
        """
        share = 1.0
        if self.kafka_brokers:
            if self.contacts_per_s() / self.fleets * MINUTE_S > COSTS["checkpoint_contacts"]:
                raise ValueError("fleets of this size write checkpoints more often than once a minute")
            contacts = self.contacts_per_s() / (self.robots * WHISKERS) * MINUTE_S
            share = COSTS["log_contacts_per_checkpoint"] / contacts
        return share * self.cost("database_us") * US, share * self.cost("wal_bytes")

    def log_bytes_per_s(self):
        """Bytes that the brokers of Kafka write: three replicas of each message."""
        return 3 * self.messages_per_s() * COSTS["message_bytes"]

    def used(self):
        """Cores and bytes per second in use, each with what there is."""
        contacts = self.contacts_per_s()
        database_s, wal_bytes = self.per_contact()
        used = {
            "MQTT": (contacts * self.cost("broker_us") * US, self.brokers),
            "supervisors": (contacts * self.cost("supervisor_us") * US, self.supervisors * self.supervisor_cores),
            "PostgreSQL": (contacts * database_s, self.database_cores),
            "WAL": (contacts * wal_bytes / 1e6, COSTS["disk_bytes_per_s"] / 1e6),
        }
        if self.kafka_brokers:
            used["Kafka"] = (contacts * COSTS["kafka_us"] * US, self.kafka_brokers * self.kafka_cores)
            used["Kafka's disks"] = (self.log_bytes_per_s() / 1e6, self.kafka_brokers * COSTS["disk_bytes_per_s"] / 1e6)
        return used

    def takeover_s(self):
        """CPU seconds to load a fleet's states, and with Kafka to read at most a minute of records again."""
        contacts = self.contacts_per_s() / self.fleets * MINUTE_S if self.kafka_brokers else 0
        states = self.robots * WHISKERS / self.fleets / COSTS["states_per_s"]
        return states + contacts * self.cost("supervisor_us") * US


class Fleet:
    """Messages of a fleet's robots that have no receipt yet, as groups of (time made, number), oldest first."""

    def __init__(self, number, plan):
        self.broker, self.supervisor = number % plan.brokers, number % plan.supervisors
        self.waiting = []
        self.stranded = []  # (time of the reconnection, time made, number): of robots whose broker is lost
        self.made_to = 0.0
        self.blocked_to = 0.0


class Site:
    """A site, and the queues in it."""

    def __init__(self, plan, seconds, faults):
        self.plan, self.random, self.seconds, self.faults = plan, random.Random(SEED), seconds, faults
        self.fleets = [Fleet(number, plan) for number in range(plan.fleets)]
        self.brokers = [[0.0] for _ in range(plan.brokers)]
        self.kafka = [0.0] * (plan.kafka_brokers * plan.kafka_cores)
        self.supervisors = [[0.0] * plan.supervisor_cores for _ in range(plan.supervisors)]
        self.database = [0.0] * plan.database_cores
        self.wal_to = self.log_to = 0.0
        self.blocked_to = 0.0
        self.broker_lost = -math.inf
        self.receipts = []  # (time made, delay, messages)

    def run(self):
        events = [(COMMIT_EVERY_S * (number + 1) / len(self.fleets), 1, number) for number in range(len(self.fleets))]
        events += [(at, 0, kind) for kind, at in self.faults.items()]
        heapq.heapify(events)
        while events:
            at, is_commit, what = heapq.heappop(events)
            if at >= self.seconds:
                break
            if is_commit:
                heapq.heappush(events, (max(self.commit(self.fleets[what], at), at + COMMIT_EVERY_S), 1, what))
            else:
                self.fail(what, at)
        return self.receipts

    def fail(self, kind, at):
        if kind == DATABASE:
            self.blocked_to = at + COSTS["database_failover_s"] + COSTS["first_contact_s"]
        elif kind == KAFKA:
            self.blocked_to = at + COSTS["kafka_failover_s"]
        elif kind == BROKER:
            self.broker_lost = at
        else:
            lost = [fleet for fleet in self.fleets if fleet.supervisor == 0]
            for turn, fleet in enumerate(lost):
                fleet.supervisor = 1 + turn % (self.plan.supervisors - 1)
                cores = self.supervisors[fleet.supervisor]
                fleet.blocked_to = serve(cores, at + COSTS["lease_s"], self.plan.takeover_s())

    def make(self, fleet, now):
        """Adds the messages that a fleet's robots made since the last time; with a noise of Poisson's size."""
        seconds, made = now - fleet.made_to, (fleet.made_to + now) / 2
        mean = self.plan.messages_per_s() / self.plan.fleets * seconds
        noise = sum(self.random.random() for _ in range(12)) - 6.0
        count = max(0, round(mean + noise * mean**0.5))
        fleet.made_to = now
        # Robots of a lost broker reconnect evenly between two times, and keep their messages until then.
        begin, end = (self.broker_lost + COSTS[name] for name in ("reconnect_from_s", "reconnect_to_s"))
        if fleet.broker == 0 and self.broker_lost <= made < end:
            away = round(count * min(1.0, (end - made) / (end - begin)))
            first, slices = max(made, begin), 10
            for turn in range(slices):
                part = away * (turn + 1) // slices - away * turn // slices
                fleet.stranded.append((first + (end - first) * (turn + 0.5) / slices, made, part))
            count -= away
        fleet.waiting.append((made, count))
        fleet.waiting += [(made, part) for back, made, part in fleet.stranded if back <= now]
        fleet.stranded = [one for one in fleet.stranded if one[0] > now]

    def commit(self, fleet, now):
        """Commits what a fleet has received, and returns when it may commit again."""
        self.make(fleet, now)
        blocked_to = max(fleet.blocked_to, self.blocked_to)
        if now < blocked_to:
            return blocked_to
        groups, fleet.waiting = fleet.waiting, []
        contacts = sum(count for _, count in groups) * CONTACTS
        database_s, wal_bytes = self.plan.per_contact()
        at = serve(self.brokers[fleet.broker], now, contacts * self.plan.cost("broker_us") * US)
        if self.kafka:
            share = contacts / self.plan.contacts_per_s() * self.plan.log_bytes_per_s()
            self.log_to = max(self.log_to, at) + share / (self.plan.kafka_brokers * COSTS["disk_bytes_per_s"])
            at = max(serve(self.kafka, at, contacts * COSTS["kafka_us"] * US), self.log_to)
        at = serve(self.supervisors[fleet.supervisor], at, contacts * self.plan.cost("supervisor_us") * US)
        self.wal_to = max(self.wal_to, at) + contacts * wal_bytes / COSTS["disk_bytes_per_s"]
        done = max(serve(self.database, at, contacts * database_s), self.wal_to) + COSTS["standby_s"]
        self.receipts += [(made, done - made, count) for made, count in groups if count]
        return done


def serve(cores, now, seconds):
    """The time at which work ends that the first free core does."""
    at = min(range(len(cores)), key=cores.__getitem__)
    cores[at] = max(cores[at], now) + seconds
    return cores[at]


def quantile(receipts, share):
    left = share * sum(count for _, _, count in receipts)
    for delay, count in sorted((delay, count) for _, delay, count in receipts):
        left -= count
        if left <= 0:
            return delay
    return 0.0


def failures(plan):
    """Longest wait for a receipt, messages that a robot then keeps, and seconds until waits are usual again."""
    kinds = [SUPERVISOR, DATABASE, BROKER] + [KAFKA] * bool(plan.kafka_brokers)
    faults = {kind: BETWEEN_S * (turn + 1) for turn, kind in enumerate(kinds)}
    receipts = Site(plan, BETWEEN_S * (len(kinds) + 1), faults).run()
    calm = [one for one in receipts if 1.0 < one[0] < BETWEEN_S - 1.0]
    usual_s = quantile(calm, 0.99)
    yield ["event", "longest wait for a receipt, s", "messages that a robot keeps", "usual again after, s"]
    longest = max(delay for _, delay, _ in calm)
    yield [f"none (p50 {quantile(calm, 0.5):.3f}, p99 {usual_s:.3f} s)", f"{longest:.2f}", "1", ""]
    for kind, at in faults.items():
        after = [one for one in receipts if at - 1.0 <= one[0] < at + BETWEEN_S - 1.0]
        longest = max(delay for _, delay, _ in after)
        until = max((made + delay for made, delay, _ in after if delay > 2 * usual_s), default=at) - at
        yield [kind, f"{longest:.1f}", f"{math.ceil(longest * MESSAGES_PER_S)}", f"{until:.1f}"]


def loads(plan, factors):
    """Use of the engines with more robots and fleets than planned, and in tier 2 with as many more MQTT brokers."""
    last = "a replica of Kafka, a day" if plan.kafka_brokers else "contacts of a day, indexed in"
    yield ["robots; contacts/s", *plan.used(), last, "longest wait in 20 s, s"]
    for factor in factors:
        more = copy.copy(plan)
        more.robots, more.fleets = plan.robots * factor, plan.fleets * factor
        more.brokers = plan.brokers * (factor if plan.kafka_brokers else 1)
        a_day = more.contacts_per_s() * 86400
        if plan.kafka_brokers:
            kept = f"{a_day / CONTACTS * COSTS['message_bytes'] / 1e12:.0f} TB"
        else:
            index_h = a_day / 1e7 * COSTS["index_s_per_10_million"] / 3600
            kept = f"{a_day * (COSTS['row_bytes'] + COSTS['index_bytes']) / 1e9:,.0f} GB, {index_h:.1f} h"
        longest = max(delay for _, delay, _ in Site(more, 20.0, {}).run())
        shares = [f"{100 * used / whole:.0f} %" for used, whole in more.used().values()]
        yield [f"{more.robots:,}; {more.contacts_per_s():,.0f}", *shares, kept, f"{longest:.2f}"]


def markdown(rows):
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    lines.insert(1, "|" + " --- |" * lines[0].count(" | ") + " --- |")
    return "\n".join(lines).replace("|  |", "| |")


PLANS = {
    "Tier 1: 250 robots, 5,000 contacts/s": (Plan(250, 1, 1, 2, 4, 4), (1, 4, 20, 80, 200)),
    "Tier 2: 100,000 robots, 2,000,000 contacts/s": (Plan(100_000, 125, 25, 5, 8, 8, 6, 8), (1, 2, 3, 4)),
}


def main():
    for name, (plan, factors) in PLANS.items():
        used = ", ".join(f"{what} {used:.2f}" for what, (used, _) in plan.used().items())
        print(f"**{name}.**\nIn use, in cores and MB/s: {used}.\n")
        print(markdown(failures(plan)) + "\n")
        print(markdown(loads(plan, factors)) + "\n")


if __name__ == "__main__":
    main()
