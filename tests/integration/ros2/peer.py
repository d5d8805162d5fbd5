"""A robot's ROS node, by another implementation of DDS (Cyclone DDS) and on 127.0.0.1 only.

It simulates the chamber of whisker left-front/0, which follows its setpoints, touches something twice a second, reports
a gauge, and does touch tests. It prints what it receives as lines of JSON: `peer.py NAMESPACE DOMAIN`. With a third
argument `short` it only publishes a contact that ends too early, with `parameters` it reads the bridge's parameters,
with `lifecycle` it configures and activates the bridge, with `sensors` it is a robot of standard messages, and with `presses`
such a robot that presses its whisker against a wall every two seconds.
"""

import json
import math
import os
import sys
import time

CONFIG = """<CycloneDDS><Domain><General><Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<MaxAutoParticipantIndex>10</MaxAutoParticipantIndex><Peers><Peer Address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>"""
os.environ["CYCLONEDDS_URI"] = CONFIG

from cyclonedds.core import Policy, Qos  # noqa: E402
from cyclonedds.domain import DomainParticipant  # noqa: E402
from cyclonedds.pub import DataWriter  # noqa: E402
from cyclonedds.sub import DataReader  # noqa: E402
from cyclonedds.topic import Topic  # noqa: E402
from cyclonedds.util import duration  # noqa: E402
from messages import (  # noqa: E402
    Call,
    ChangeStateRequest,
    ChangeStateResponse,
    Contact,
    DiagnosticArray,
    DiagnosticStatus,
    Estimate,
    Fault,
    Float32MultiArray,
    Float64,
    FluidPressure,
    GetParametersRequest,
    GetParametersResponse,
    GetResultRequest,
    GetResultResponse,
    GetStateRequest,
    GetStateResponse,
    Header,
    JointState,
    KeyValue,
    MultiArrayDimension,
    MultiArrayLayout,
    Result,
    SendGoalRequest,
    SendGoalResponse,
    ShortContact,
    Strain,
    Time,
    Transition,
    TransitionEvent,
    Vector3,
    Wrench,
    WrenchStamped,
)

ATMOSPHERE_PA = 101_325.0
# `STATUS_SUCCEEDED` of action_msgs/msg/GoalStatus.
SUCCEEDED = 4
SENSOR_DATA = Qos(Policy.Reliability.BestEffort, Policy.Durability.Volatile, Policy.History.KeepLast(5))
RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10))
LATCHED = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.TransientLocal, Policy.History.KeepLast(1)
)


def show(**what):
    print(json.dumps(what), flush=True)


def stamp():
    now = time.time()
    return Time(int(now), int(now % 1 * 1e9))


def header():
    return Header(stamp(), "")


def contact(strain, test_id="", missed=False, saturated=False):
    return Contact(header(), "left-front", 0, 0.002, strain, 1, 0.05, 0.0005, 0.0, 0.0, test_id, missed, saturated)


def writer(participant, name, kind, qos):
    return DataWriter(participant, Topic(participant, name, kind), qos=qos)


def reader(participant, name, kind, qos):
    return DataReader(participant, Topic(participant, name, kind), qos=qos)


class TouchTests:
    """The server of the action touch_test, which has done each test when its result is requested."""

    def __init__(self, participant, namespace):
        name = f"{namespace}/touch_test/_action"
        self.goals = reader(participant, f"rq{name}/send_goalRequest", SendGoalRequest, RELIABLE)
        self.answers = writer(participant, f"rr{name}/send_goalReply", SendGoalResponse, RELIABLE)
        self.requests = reader(participant, f"rq{name}/get_resultRequest", GetResultRequest, RELIABLE)
        self.results = writer(participant, f"rr{name}/get_resultReply", GetResultResponse, RELIABLE)
        self.accepted = {}

    def step(self):
        for request in self.goals.take(N=10):
            self.accepted[tuple(request.goal_id)] = request.goal
            show(goal=[request.goal.test_id, request.goal.kind, request.goal.distances_m, request.goal.contacts])
            self.answers.write(SendGoalResponse(request.call, True, stamp()))
        for request in self.requests.take(N=10):
            goal = self.accepted[tuple(request.goal_id)]
            touches = [contact(0.0102, goal.test_id, saturated=True), contact(0.0, goal.test_id, missed=True)]
            self.results.write(GetResultResponse(request.call, SUCCEEDED, Result(touches, "")))


def publish_short_contacts(participant, namespace):
    short = writer(participant, f"rt{namespace}/contacts", ShortContact, SENSOR_DATA)
    while True:
        short.write(ShortContact(header(), "left-front"))
        time.sleep(0.1)


def read_parameters(participant, namespace):
    service = f"{namespace}/vibrissa/get_parameters"
    requests = writer(participant, f"rq{service}Request", GetParametersRequest, RELIABLE)
    replies = reader(participant, f"rr{service}Reply", GetParametersResponse, RELIABLE)
    while True:
        requests.write(GetParametersRequest(["pressures", "atmosphere_pa", "robot"]))
        for reply in replies.take(N=10):
            pressures, atmosphere_pa, robot = reply.values
            show(parameters=[pressures.string_value, atmosphere_pa.double_value, robot.string_value])
        time.sleep(0.1)


def change_states(participant, namespace):
    node = f"{namespace}/vibrissa"
    changes = writer(participant, f"rq{node}/change_stateRequest", ChangeStateRequest, RELIABLE)
    changed = reader(participant, f"rr{node}/change_stateReply", ChangeStateResponse, RELIABLE)
    questions = writer(participant, f"rq{node}/get_stateRequest", GetStateRequest, RELIABLE)
    states = reader(participant, f"rr{node}/get_stateReply", GetStateResponse, RELIABLE)
    events = reader(participant, f"rt{node}/transition_event", TransitionEvent, RELIABLE)
    call = Call([7] * 8, 0, 1)
    while True:
        questions.write(GetStateRequest(call, 0))
        for reply in states.take(N=10):
            state = reply.current_state.label
            show(state=state)
            next_label = {"unconfigured": "configure", "inactive": "activate"}.get(state)
            if next_label:
                changes.write(ChangeStateRequest(call, Transition(0, next_label)))
        for reply in changed.take(N=10):
            show(changed=reply.success)
        for event in events.take(N=10):
            show(event=[event.start_state.label, event.goal_state.label])
        time.sleep(0.1)


def publish_sensors(participant):
    """A robot that knows nothing of whiskers: odd lengths of texts and lists shift what follows them."""
    joints = writer(participant, "rt/joint_states", JointState, SENSOR_DATA)
    gauges = writer(participant, "rt/gauges", Float32MultiArray, SENSOR_DATA)
    wrenches = writer(participant, "rt/wrench", WrenchStamped, SENSOR_DATA)
    chambers = writer(participant, "rt/chamber", Float64, SENSOR_DATA)
    diagnostics = writer(participant, "rt/valves", DiagnosticArray, RELIABLE)
    setpoints = reader(participant, "rt/valve_command", Float64, RELIABLE)
    layout = MultiArrayLayout([MultiArrayDimension("gauge", 3, 3)], 0)
    while True:
        joints.write(JointState(header(), ["wheel", "slide_0"], [9.0, 0.0021], [], [1.0]))
        gauges.write(Float32MultiArray(layout, [0.0, 0.25, 0.5]))
        wrenches.write(WrenchStamped(header(), Wrench(Vector3(1.0, 2.0, 3.0), Vector3(4.0, 5.0, 6.0))))
        chambers.write(Float64(0.8))
        values = [KeyValue("supply", "4.5"), KeyValue("level", "2")]
        diagnostics.write(DiagnosticArray(header(), [DiagnosticStatus(1, "fan", "", "x", []), DiagnosticStatus(0, "valve", "ok", "", values)]))
        for setpoint in setpoints.take(N=100):
            show(setpoint=setpoint.data)
        time.sleep(0.05)


def press(participant):
    joints = writer(participant, "rt/joint_states", JointState, SENSOR_DATA)
    gauges = writer(participant, "rt/gauges", Float32MultiArray, SENSOR_DATA)
    chambers = writer(participant, "rt/chamber", Float64, SENSOR_DATA)
    begun = time.monotonic()
    for step in range(100_000):
        phase_s = step * 0.02 % 2.0
        # The deflections differ: a gauge that is stuck gives the same numbers again.
        deepest_mm = 1.5 + step // 100 % 7 * 0.1
        way_mm = deepest_mm * (min(max((phase_s - 0.5) / 0.3, 0.0), 1.0) - min(max((phase_s - 1.2) / 0.3, 0.0), 1.0))
        noise = 0.002 * math.sin(7.0 * step)
        joints.write(JointState(header(), ["slide_0"], [(10.0 + way_mm) * 1e-3], [], []))
        gauges.write(Float32MultiArray(MultiArrayLayout([], 0), [1.0 + 4.6 * way_mm + noise, 56.0]))
        if step % 10 == 0:
            chambers.write(Float64(0.8))
        time.sleep(max(0.0, begun + (step + 1) * 0.02 - time.monotonic()))


def main():
    namespace, domain = sys.argv[1], int(sys.argv[2])
    participant = DomainParticipant(domain)
    if sys.argv[3:] == ["short"]:
        publish_short_contacts(participant, namespace)
    if sys.argv[3:] == ["parameters"]:
        read_parameters(participant, namespace)
    if sys.argv[3:] == ["lifecycle"]:
        change_states(participant, namespace)
    if sys.argv[3:] == ["sensors"]:
        publish_sensors(participant)
    if sys.argv[3:] == ["presses"]:
        press(participant)
    whisker = f"rt{namespace}/left_front/whisker_0"
    contacts = writer(participant, f"rt{namespace}/contacts", Contact, SENSOR_DATA)
    faults = writer(participant, f"rt{namespace}/faults", Fault, RELIABLE)
    readings = writer(participant, f"{whisker}/pressure", FluidPressure, SENSOR_DATA)
    strains = writer(participant, f"{whisker}/strain", Strain, SENSOR_DATA)
    setpoints = reader(participant, f"{whisker}/setpoint", FluidPressure, RELIABLE)
    estimates = reader(participant, f"{whisker}/estimate", Estimate, LATCHED)
    reports = reader(participant, "rt/diagnostics", DiagnosticArray, RELIABLE)
    tests = TouchTests(participant, namespace)
    pressure_pa = ATMOSPHERE_PA + 50_000.0
    for step in range(10_000):
        readings.write(FluidPressure(header(), pressure_pa, 0.0))
        if step % 10 == 0:
            # Every fourth contact has no strain, which the bridge must refuse.
            contacts.write(contact(math.nan if step % 40 == 0 else 0.0123))
            strains.write(Strain(header(), [0.001, 0.002, 0.003], [], 1000, [0.002], [], ""))
            faults.write(Fault(header(), "left-front", 0, "OK", ""))
        for setpoint in setpoints.take(N=100):
            pressure_pa = setpoint.fluid_pressure
            show(setpoint_pa=pressure_pa, frame_id=setpoint.header.frame_id)
        for estimate in estimates.take(N=10):
            show(estimate=[estimate.length_m, estimate.condition, estimate.gain_ratio, estimate.gain])
        for report in reports.take(N=100):
            show(
                report={
                    one.name: [one.level, one.message, one.hardware_id, {v.key: v.value for v in one.values}]
                    for one in report.status
                }
            )
        tests.step()
        time.sleep(0.05)


main()
