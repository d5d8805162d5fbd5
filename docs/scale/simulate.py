#!/usr/bin/env python3
"""Simulates cells of robots, brokers, supervisors and a PostgreSQL, and what failures do to their queues.

A discrete-event simulation of group commits: docs/scale.md describes the model and has the results. It needs only Python, and
the same arguments give the same output.
"""

import argparse
import copy
import heapq
import math
import random

US = 1e-6

# Measured inputs: CPU seconds, bytes, and seconds. docs/scale.md names the source of each.
BROKER_S_PER_MESSAGE = 14.2 * US
SUPERVISOR_S_PER_MESSAGE = 4.1 * US  # with its first contact
SUPERVISOR_S_PER_FURTHER_CONTACT = 2.0 * US
INSERT_S_PER_CONTACT = 3.0 * US  # commits of fewer than COPY_CONTACTS
COPY_S_PER_CONTACT = 1.8 * US
COPY_CONTACTS = 2000
COMMIT_S = 250 * US  # CPU of a commit besides its contacts
WAL_BYTES_PER_CONTACT = 130
STATES_PER_S = 111_000  # whiskers that one supervisor loads per second at a takeover
LEASE_S = 2.0
DATABASE_FAILOVER_S = 5.6 + 0.7
COMMIT_EVERY_S = 0.1
# Not measured: round trip to the synchronous standby with its fsync, and reconnections after a lost broker node.
STANDBY_S = 0.002
RECONNECT_S = (1.0, 10.0)

ROBOT = {"messages_per_s": 1.0, "contacts": 9, "whiskers": 9}
ALL_FAULTS = ("supervisor killed", "PostgreSQL fails over", "broker node lost")


class Plan:
    """Engines of a cell."""

    def __init__(self, robots, shards, supervisors, supervisor_cores, brokers, broker_cores, database_cores, wal_bytes_per_s):
        self.robots, self.shards = robots, shards
        self.supervisors, self.supervisor_cores = supervisors, supervisor_cores
        self.brokers, self.broker_cores = brokers, broker_cores
        self.database_cores, self.wal_bytes_per_s = database_cores, wal_bytes_per_s

    def cores(self):
        """Cores in use by brokers, supervisors and the database, and bytes of WAL per second, without failures."""
        messages = self.robots * ROBOT["messages_per_s"]
        contacts = messages * ROBOT["contacts"]
        per_commit = contacts / self.shards * COMMIT_EVERY_S
        per_contact = COPY_S_PER_CONTACT if per_commit >= COPY_CONTACTS else INSERT_S_PER_CONTACT
        supervisor = messages * message_s()
        database = contacts * per_contact + self.shards / COMMIT_EVERY_S * COMMIT_S
        return messages * BROKER_S_PER_MESSAGE, supervisor, database, contacts * WAL_BYTES_PER_CONTACT


def message_s():
    return SUPERVISOR_S_PER_MESSAGE + (ROBOT["contacts"] - 1) * SUPERVISOR_S_PER_FURTHER_CONTACT


class Shard:
    """Messages of a shard's robots that have no receipt yet, as groups of (time made, number), oldest first."""

    def __init__(self, robots, supervisor):
        self.robots, self.supervisor = robots, supervisor
        self.waiting = []
        self.stranded = []  # (time of the reconnection, time made, number): of robots whose broker node is lost
        self.made_to = 0.0
        self.blocked_to = 0.0


class Cell:
    """One cell, which shares nothing with others."""

    def __init__(self, plan, seed, seconds, faults):
        self.plan, self.random, self.seconds, self.faults = plan, random.Random(seed), seconds, faults
        self.shards = [
            Shard(plan.robots / plan.shards, number % plan.supervisors) for number in range(plan.shards)
        ]
        self.brokers = [[0.0] * plan.broker_cores for _ in range(plan.brokers)]
        self.node_lost = -math.inf
        self.database = [0.0] * plan.database_cores
        self.wal_to = 0.0
        self.database_back = 0.0
        self.supervisor_to = [[0.0] * plan.supervisor_cores for _ in range(plan.supervisors)]
        self.receipts = []  # (time made, delay, messages)

    def run(self):
        events = [(COMMIT_EVERY_S * (number + 1) / len(self.shards), 1, number) for number in range(len(self.shards))]
        events += [(at, 0, kind) for kind, at in self.faults.items()]
        heapq.heapify(events)
        while events:
            at, is_commit, what = heapq.heappop(events)
            if at >= self.seconds:
                break
            if is_commit:
                heapq.heappush(events, (max(self.commit(self.shards[what], at), at + COMMIT_EVERY_S), 1, what))
            else:
                self.fail(what, at)

    def fail(self, kind, at):
        plan = self.plan
        if kind == "PostgreSQL fails over":
            self.database_back = at + DATABASE_FAILOVER_S
        elif kind == "broker node lost":
            self.node_lost = at
        else:
            lost = [shard for shard in self.shards if shard.supervisor == 0]
            others = list(range(1, plan.supervisors))
            for turn, shard in enumerate(lost):
                shard.supervisor = others[turn % len(others)]
                # Each heir loads its new shards one after the other.
                before = turn // len(others) + 1
                shard.blocked_to = at + LEASE_S + before * shard.robots * ROBOT["whiskers"] / STATES_PER_S

    def make(self, shard, now):
        """Adds the messages that a shard's robots made since the last time; with a noise of Poisson's size."""
        seconds, made = now - shard.made_to, (shard.made_to + now) / 2
        mean = shard.robots * ROBOT["messages_per_s"] * seconds
        noise = sum(self.random.random() for _ in range(12)) - 6.0
        count = max(0, round(mean + noise * mean**0.5))
        shard.made_to = now
        # Robots of a lost node reconnect to others, evenly between two times, and keep their messages until then.
        begin, end = (self.node_lost + after for after in RECONNECT_S)
        if self.node_lost <= made < end:
            away = min(1.0, (end - made) / (end - begin)) / self.plan.brokers
            slices = 10
            for turn in range(slices):
                back = max(made, begin) + (end - max(made, begin)) * (turn + 0.5) / slices
                part = round(count * away * (turn + 1) / slices) - round(count * away * turn / slices)
                shard.stranded.append((back, made, part))
            count -= round(count * away)
        shard.waiting.append((made, count))
        if shard.stranded:
            shard.waiting += [(made, part) for back, made, part in shard.stranded if back <= now]
            shard.stranded = [one for one in shard.stranded if one[0] > now]

    def commit(self, shard, now):
        """Commits what a shard has received, and returns when it may commit again."""
        self.make(shard, now)
        if now < max(shard.blocked_to, self.database_back):
            return max(shard.blocked_to, self.database_back)
        groups, shard.waiting = shard.waiting, []
        messages = sum(count for _, count in groups)
        contacts = messages * ROBOT["contacts"]
        is_lost = now < self.node_lost + RECONNECT_S[1] and now >= self.node_lost
        nodes = self.brokers[1:] if is_lost else self.brokers
        passed = max(serve(node, now, messages / len(nodes) * BROKER_S_PER_MESSAGE) for node in nodes)
        received = serve(self.supervisor_to[shard.supervisor], passed, messages * message_s())
        per_contact = COPY_S_PER_CONTACT if contacts >= COPY_CONTACTS else INSERT_S_PER_CONTACT
        written = serve(self.database, received, COMMIT_S + contacts * per_contact)
        self.wal_to = max(self.wal_to, received) + contacts * WAL_BYTES_PER_CONTACT / self.plan.wal_bytes_per_s
        done = max(written, self.wal_to) + STANDBY_S
        self.receipts += [(made, done - made, count) for made, count in groups if count]
        return done


def serve(cores, now, seconds):
    """The time at which work ends that the first free core does."""
    at = min(range(len(cores)), key=cores.__getitem__)
    cores[at] = max(cores[at], now) + seconds
    return cores[at]


def quantile(receipts, share):
    ordered = sorted((delay, count) for _, delay, count in receipts)
    left = share * sum(count for _, count in ordered)
    for delay, count in ordered:
        left -= count
        if left <= 0:
            return delay
    return 0.0


def effect(receipts, at, until, usual_s):
    """Longest delay of a receipt, messages that a robot then keeps, and seconds until delays are usual again."""
    receipts = [one for one in receipts if at - 1.0 <= one[0] < until]
    longest = max(delay for _, delay, _ in receipts)
    late = [made + delay for made, delay, _ in receipts if delay > 2 * usual_s]
    return longest, math.ceil(longest * ROBOT["messages_per_s"]), max(late, default=at) - at


def table(plan, cells, seconds, seed):
    step = seconds / (len(ALL_FAULTS) + 1)
    faults = {kind: step * (turn + 1) for turn, kind in enumerate(ALL_FAULTS)}
    receipts = []
    for number in range(cells):
        cell = Cell(plan, seed + number, seconds, faults)
        cell.run()
        receipts += cell.receipts
    calm = [one for one in receipts if 1.0 < one[0] < step - 1.0]
    usual_s = quantile(calm, 0.99)
    lines = [
        "| event | longest wait for a receipt, s | messages that a robot keeps | usual again after, s |",
        "| --- | --- | --- | --- |",
        f"| none (p50 {quantile(calm, 0.5):.3f} s, p99 {usual_s:.3f} s) | {max(delay for _, delay, _ in calm):.3f} | 1 | |",
    ]
    for kind, at in faults.items():
        longest, kept, until = effect(receipts, at, at + step - 1.0, usual_s)
        lines.append(f"| {kind} | {longest:.1f} | {kept} | {until:.1f} |")
    return "\n".join(lines)


def loads(plan, seed):
    """Waits for receipts of one cell with more robots than planned, without failures."""
    lines = [
        "| robots in a cell | brokers | supervisors | PostgreSQL | WAL | longest wait in 20 s, s |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for factor in (1, 2, 3, 4, 6):
        more = copy.copy(plan)
        more.robots = plan.robots * factor
        broker, supervisor, database, wal = more.cores()
        cell = Cell(more, seed, 20.0, {})
        cell.run()
        shares = [
            broker / (plan.brokers * plan.broker_cores),
            supervisor / (plan.supervisors * plan.supervisor_cores),
            database / plan.database_cores,
            wal / plan.wal_bytes_per_s,
        ]
        longest = max(delay for _, delay, _ in cell.receipts)
        used = " | ".join(f"{100 * share:.0f} %" for share in shares)
        lines.append(f"| {more.robots:,} | {used} | {longest:.2f} |")
    return "\n".join(lines)


PLANS = {
    "cell": Plan(100_000, 16, 4, 8, 4, 8, 16, 400e6),
    "small": Plan(8_000, 8, 4, 2, 4, 2, 4, 400e6),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--plan", choices=PLANS, default="cell")
    parser.add_argument("--cells", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=160.0)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    plan = PLANS[options.plan]
    broker, supervisor, database, wal = plan.cores()
    print(f"{options.cells * plan.robots:,} robots in {options.cells} cells, {options.seconds:.0f} s, seed {options.seed}")
    print(f"per cell: brokers {broker:.2f} cores, supervisors {supervisor:.2f}, PostgreSQL {database:.2f}, WAL {wal / 1e6:.1f} MB/s")
    print()
    print(table(plan, options.cells, options.seconds, options.seed))
    print()
    print(loads(plan, options.seed))


if __name__ == "__main__":
    main()
