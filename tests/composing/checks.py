"""Checks of the running stack."""

import json
import re
import time

from .engine import run
from .stack import until

ENDS = {"grafana-role"}
OWNER = "SELECT holder FROM leases WHERE fleet = 'example' AND owner IS NOT NULL AND expires_us > clock_us()"
CUT = "SELECT length_mm FROM whiskers JOIN arrays USING (array_id) JOIN robots ON robots.robot_id = arrays.robot_id " \
      "WHERE robot = 'crawler-1' AND \"array\" = 'left' AND whisker = 1"
TRIMS = f"SELECT count(*) FROM trims JOIN whiskers USING (whisker_id) WHERE whisker_id = ({CUT.replace('length_mm', 'whisker_id', 1)})"
CONTACTS = "SELECT count(*) FROM contacts"


def one_build_for_each_image(stack):
    images = {name: stack.inspect(name)["Image"] for name in ("supervisor-1", "supervisor-2")}
    assert len(set(images.values())) == 1, images
    builds = [name for name in stack.services() if "build" in stack.resolved["services"][name]]
    assert builds == ["simulator", "supervisor-1"], builds


def everything_is_healthy(stack):
    for name in stack.services():
        def state(name=name):
            return stack.inspect(name)["State"]
        if name in ENDS:
            until(f"{name} has exited", lambda: state()["Status"] == "exited")
            assert state()["ExitCode"] == 0, stack.logs(name)
        elif "healthcheck" in stack.resolved["services"][name]:
            until(f"{name} is healthy", lambda: state()["Health"]["Status"] == "healthy")
        else:
            assert state()["Running"] and stack.inspect(name)["RestartCount"] == 0, stack.logs(name)


def nobody_is_root_or_writes_to_an_image(stack):
    for name in stack.services():
        told = stack.inspect(name)
        host = told["HostConfig"]
        assert host["ReadonlyRootfs"] and host["CapDrop"] == ["ALL"] and not host["Privileged"], name
        assert host["SecurityOpt"] == ["no-new-privileges:true"], name
        if name in ENDS:
            continue
        status = open(f"/proc/{told['State']['Pid']}/status").read()
        users = re.search(r"^Uid:\s+(.*)$", status, re.M).group(1).split()
        assert "0" not in users, f"{name} runs as {users}"
        assert re.search(r"^CapEff:\s+0+$", status, re.M) and re.search(r"^NoNewPrivs:\s+1$", status, re.M), f"{name}:\n{status}"
        refused = run("docker", "exec", told["Id"], "sh", "-c", "touch /usr/written 2>/dev/null || echo refused")
        assert refused.strip() == "refused", name


def logs_are_limited(stack):
    for name in stack.services():
        log = stack.inspect(name)["HostConfig"]["LogConfig"]
        assert log["Type"] == "json-file" and log["Config"].keys() == {"max-size", "max-file"}, (name, log)


def folders_in_memory_have_their_owners(stack):
    expected = {
        ("broker", "/mosquitto/log"): "1883:1883",
        ("postgres", "/var/run/postgresql"): "999:999",
        ("postgres", "/tmp"): "0:0",
        ("grafana", "/var/log/grafana"): "472:0",
        ("supervisor-1", "/tmp"): "0:0",
    }
    for (service, folder), owner in expected.items():
        # Older versions of runc take the mode from the image if the folder exists there.
        told = stack.execute(service, "stat", "-c", "%u:%g", folder).strip()
        assert told == owner, f"{service}: {folder} has {told}, not {owner}"
        assert "mode=" in stack.inspect(service)["HostConfig"]["Tmpfs"][folder], folder


def the_access_list_is_for_the_broker_alone(stack):
    for name in ("acl", "passwords", "supervisor_passwords"):
        told = stack.execute("broker", "stat", "-c", "%u:%g %a", f"/mosquitto/secrets/{name}").strip()
        assert told == "1883:1883 600", f"{name} has {told}"
    log = stack.logs("broker")
    assert "world" not in log and "Warning" not in log and "Error" not in log, log


def health_checks_of_the_broker_leave_no_lines(stack):
    def checks():
        return len(stack.inspect("broker")["State"]["Health"]["Log"])
    before, lines = checks(), len(stack.logs("broker").splitlines())
    began = time.monotonic()
    # Docker keeps the last five results.
    until("a health check", lambda: time.monotonic() - began > 25 and (checks() > before or checks() == 5), 60)
    new = stack.logs("broker").splitlines()[lines:]
    assert not [line for line in new if "127.0.0.1" in line or "<unknown>" in line], new
    assert not new, new


def no_colours_outside_a_terminal(stack):
    for name in ("supervisor-1", "supervisor-2", "simulator"):
        lines = [line for line in stack.logs(name).splitlines() if "\x1b" in line]
        assert not lines, f"{name}: {len(lines)} lines, such as {lines[0]!r}"


def supervisors_are_no_superusers(stack):
    assert stack.sql("SELECT rolsuper OR rolcreatedb OR rolcreaterole FROM pg_roles WHERE rolname = 'supervisor'") == "f"
    users = stack.sql("SELECT string_agg(DISTINCT usename, ',') FROM pg_stat_activity WHERE client_addr IS NOT NULL")
    assert users == "supervisor", users
    # The audit log has an owner of its own, as which nobody can connect.
    others = stack.sql("SELECT string_agg(DISTINCT relname || ' ' || pg_get_userbyid(relowner), ',') FROM pg_class "
                       "WHERE relnamespace = 'public'::regnamespace AND relkind IN ('r', 'p') "
                       "AND pg_get_userbyid(relowner) <> 'supervisor'")
    assert others == "actions supervisor_owner", others
    assert stack.sql("SELECT has_table_privilege('supervisor', 'actions', 'DELETE')") == "f"
    assert stack.sql("SELECT rolcanlogin FROM pg_roles WHERE rolname = 'supervisor_owner'") == "f"
    assert stack.sql("SELECT rolsuper FROM pg_roles WHERE rolname = 'grafana'") == "f"
    assert stack.sql("SELECT has_table_privilege('grafana', 'contacts', 'SELECT')") == "t"


def contacts_are_recorded(stack):
    before = int(stack.sql(CONTACTS))
    until("200 more contacts", lambda: int(stack.sql(CONTACTS)) > before + 200)


def prometheus_sees_both_supervisors(stack):
    def up():
        answer = stack.http(9090, "/api/v1/query?query=sum(up%7Bjob%3D%22vibrissa%22%7D)")
        result = json.loads(answer[1])["data"]["result"] if answer and answer[0] == 200 else []
        return result and result[0]["value"][1] == "2"
    until("both targets are up", up)


def _state(stack):
    text = stack.execute("simulator", "cat", "/var/lib/vibrissa/simulator.json")
    robots = json.loads(text)["robots"]
    return {(robot["robot"], whisker["array"], whisker["whisker"]): whisker for robot in robots for whisker in robot["whiskers"]}


def a_simulator_that_is_killed_remembers_its_cuts(stack):
    cut = ("crawler-1", "left", 1)
    until("the cut of crawler-1/left/1 is detected", lambda: int(stack.sql(TRIMS)) == 1, 400)
    until("its length is estimated", lambda: abs(float(stack.sql(CUT)) - 65) < 1.5)
    before = _state(stack)[cut]["plant"]
    assert before["length_mm"] == 65.0, before
    restarts = stack.inspect("simulator")["RestartCount"]
    stack.kill("simulator")
    until("the simulator is restarted", lambda: stack.inspect("simulator")["RestartCount"] > restarts)
    contacts = int(stack.sql(CONTACTS))
    until("500 more contacts", lambda: int(stack.sql(CONTACTS)) > contacts + 500)
    after = _state(stack)[cut]["plant"]
    assert (after["length_mm"], after["changes"], after["rubber"]) == (65.0, before["changes"], before["rubber"]), after
    assert after["contacts"] > before["contacts"] - 100, after
    length = float(stack.sql(CUT))
    assert abs(length - 65) < 1.5 and int(stack.sql(TRIMS)) == 1, f"{length} mm, {stack.sql(TRIMS)} trims"


def an_outage_of_the_database_is_logged_once(stack):
    names = ("supervisor-1", "supervisor-2")
    before = {name: stack.logs(name).count("cannot renew the leases") for name in names}
    run("docker", "pause", stack.container("postgres"))
    try:
        until("supervisor-1 is not ready", lambda: not stack.is_ready("supervisor-1"))
        time.sleep(8)
    finally:
        run("docker", "unpause", stack.container("postgres"))
    until("an owner", lambda: stack.sql(OWNER))
    lines = {name: stack.logs(name).count("cannot renew the leases") - before[name] for name in names}
    # The owner of the fleet must say it, and whoever says it must not repeat it.
    assert sum(lines.values()) > 0 and max(lines.values()) <= 2, f"lines that say that leases cannot be kept: {lines}"
    return f"lines: {lines}"


def the_other_supervisor_takes_over_after_a_kill(stack):
    until("readiness", lambda: stack.is_ready("supervisor-1") and stack.is_ready("supervisor-2"))
    owner = until("the fleet has an owner", lambda: stack.sql(OWNER))
    began = time.monotonic()
    # `docker kill` counts as intended, so the engine does not restart the container, which could acquire the fleet
    # first.
    container = stack.container(owner)
    run("docker", "kill", container)
    heir = until("the fleet has another owner", lambda: next((name for name in [stack.sql(OWNER)] if name and name != owner), None), 30)
    seconds = time.monotonic() - began
    contacts_are_recorded(stack)
    run("docker", "start", container)
    until(f"{owner} is healthy again", lambda: stack.inspect(owner)["State"]["Health"]["Status"] == "healthy")
    return f"{owner} to {heir} in {seconds:.1f} s"


def no_anonymous_volume_remains(stack, before):
    stack.compose("down")
    left = set(stack.volumes()) - set(before)
    named = {f"{stack.name}_{name}" for name in stack.resolved["volumes"]}
    assert left == named, f"{left - named} beyond the named volumes, {named - left} missing"
    stack.compose("down", "--volumes")
    assert set(stack.volumes()) == set(before)


# The order matters: later checks disturb the stack.
CHECKS = [
    one_build_for_each_image,
    everything_is_healthy,
    nobody_is_root_or_writes_to_an_image,
    logs_are_limited,
    folders_in_memory_have_their_owners,
    the_access_list_is_for_the_broker_alone,
    supervisors_are_no_superusers,
    contacts_are_recorded,
    prometheus_sees_both_supervisors,
    health_checks_of_the_broker_leave_no_lines,
    a_simulator_that_is_killed_remembers_its_cuts,
    the_other_supervisor_takes_over_after_a_kill,
    an_outage_of_the_database_is_logged_once,
    no_colours_outside_a_terminal,
]
