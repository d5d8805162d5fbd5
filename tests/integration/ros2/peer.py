"""A robot's ROS node, by another implementation of DDS (Cyclone DDS) and on 127.0.0.1 only.

It simulates the chamber of whisker left-front/0, which follows its setpoints, and touches something twice a second. It
prints what it receives as lines of JSON: `peer.py NAMESPACE DOMAIN`. With a third argument it only publishes a contact
that ends too early.
"""

import json
import math
import os
import sys
import time
from dataclasses import dataclass

CONFIG = """<CycloneDDS><Domain><General><Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<MaxAutoParticipantIndex>10</MaxAutoParticipantIndex><Peers><Peer Address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>"""
os.environ["CYCLONEDDS_URI"] = CONFIG

from cyclonedds.core import Policy, Qos  # noqa: E402
from cyclonedds.domain import DomainParticipant  # noqa: E402
from cyclonedds.idl import IdlStruct  # noqa: E402
from cyclonedds.idl.types import float64, int32, sequence, uint8, uint16, uint32  # noqa: E402
from cyclonedds.pub import DataWriter  # noqa: E402
from cyclonedds.sub import DataReader  # noqa: E402
from cyclonedds.topic import Topic  # noqa: E402
from cyclonedds.util import duration  # noqa: E402

ATMOSPHERE_PA = 101_325.0


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class Contact(IdlStruct, typename="vibrissa_msgs::msg::dds_::Contact_"):
    header: Header
    array: str
    whisker: uint16
    deflection_m: float64
    strain: float64
    place: uint8
    distance_m: float64
    distance_sd_m: float64
    ratio: float64
    ratio_sd: float64
    test_id: str
    missed: bool


@dataclass
class ShortContact(IdlStruct, typename="vibrissa_msgs::msg::dds_::Contact_"):
    header: Header
    array: str


@dataclass
class FluidPressure(IdlStruct, typename="sensor_msgs::msg::dds_::FluidPressure_"):
    header: Header
    fluid_pressure: float64
    variance: float64


@dataclass
class KeyValue(IdlStruct, typename="diagnostic_msgs::msg::dds_::KeyValue_"):
    key: str
    value: str


@dataclass
class DiagnosticStatus(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticStatus_"):
    level: uint8
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]


@dataclass
class DiagnosticArray(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticArray_"):
    header: Header
    status: sequence[DiagnosticStatus]


SENSOR_DATA = Qos(Policy.Reliability.BestEffort, Policy.Durability.Volatile, Policy.History.KeepLast(5))
RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10))
LATCHED = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.TransientLocal, Policy.History.KeepLast(1)
)


def show(**what):
    print(json.dumps(what), flush=True)


def header():
    now = time.time()
    return Header(Time(int(now), int(now % 1 * 1e9)), "")


def contact(strain):
    return Contact(header(), "left-front", 0, 0.002, strain, 1, 0.05, 0.0005, 0.0, 0.0, "", False)


def main():
    namespace, domain = sys.argv[1], int(sys.argv[2])
    participant = DomainParticipant(domain)
    if len(sys.argv) > 3:
        short = DataWriter(participant, Topic(participant, f"rt{namespace}/contacts", ShortContact), qos=SENSOR_DATA)
        while True:
            short.write(ShortContact(header(), "left-front"))
            time.sleep(0.1)
    whisker = f"rt{namespace}/left_front/whisker_0"
    contacts = DataWriter(participant, Topic(participant, f"rt{namespace}/contacts", Contact), qos=SENSOR_DATA)
    readings = DataWriter(participant, Topic(participant, f"{whisker}/pressure", FluidPressure), qos=SENSOR_DATA)
    setpoints = DataReader(participant, Topic(participant, f"{whisker}/setpoint", FluidPressure), qos=LATCHED)
    reports = DataReader(participant, Topic(participant, "rt/diagnostics", DiagnosticArray), qos=RELIABLE)
    pressure_pa = ATMOSPHERE_PA + 50_000.0
    for step in range(10_000):
        readings.write(FluidPressure(header(), pressure_pa, 0.0))
        if step % 10 == 0:
            # Every fourth contact has no strain, which the bridge must refuse.
            contacts.write(contact(math.nan if step % 40 == 0 else 0.0123))
        for setpoint in setpoints.take(N=100):
            pressure_pa = setpoint.fluid_pressure
            show(setpoint_pa=pressure_pa, frame_id=setpoint.header.frame_id)
        for report in reports.take(N=100):
            show(
                report={
                    one.name: [one.level, one.message, one.hardware_id, {v.key: v.value for v in one.values}]
                    for one in report.status
                }
            )
        time.sleep(0.05)


main()
