"""The messages of ROS that the node uses, as DDS types."""

from dataclasses import dataclass

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int8, int32, int64, sequence, uint8, uint16, uint32, uint64


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
    saturated: bool


@dataclass
class ShortContact(IdlStruct, typename="vibrissa_msgs::msg::dds_::Contact_"):
    header: Header
    array: str


@dataclass
class Strain(IdlStruct, typename="vibrissa_msgs::msg::dds_::Strain_"):
    header: Header
    strain: sequence[float64]
    strain_2: sequence[float64]
    every_us: uint32
    deflection_m: sequence[float64]
    distance_m: sequence[float64]
    test_id: str


@dataclass
class Fault(IdlStruct, typename="vibrissa_msgs::msg::dds_::Fault_"):
    header: Header
    array: str
    whisker: uint16
    gauge: str
    regulator: str


@dataclass
class Estimate(IdlStruct, typename="vibrissa_msgs::msg::dds_::Estimate_"):
    header: Header
    array: str
    whisker: uint16
    length_m: float64
    length_low_m: float64
    length_high_m: float64
    condition: str
    gain_ratio: sequence[float64]
    gain: sequence[float64]


@dataclass
class FluidPressure(IdlStruct, typename="sensor_msgs::msg::dds_::FluidPressure_"):
    header: Header
    fluid_pressure: float64
    variance: float64


@dataclass
class Float64(IdlStruct, typename="std_msgs::msg::dds_::Float64_"):
    data: float64


@dataclass
class MultiArrayDimension(IdlStruct, typename="std_msgs::msg::dds_::MultiArrayDimension_"):
    label: str
    size: uint32
    stride: uint32


@dataclass
class MultiArrayLayout(IdlStruct, typename="std_msgs::msg::dds_::MultiArrayLayout_"):
    dim: sequence[MultiArrayDimension]
    data_offset: uint32


@dataclass
class Float32MultiArray(IdlStruct, typename="std_msgs::msg::dds_::Float32MultiArray_"):
    layout: MultiArrayLayout
    data: sequence[float32]


@dataclass
class JointState(IdlStruct, typename="sensor_msgs::msg::dds_::JointState_"):
    header: Header
    name: sequence[str]
    position: sequence[float64]
    velocity: sequence[float64]
    effort: sequence[float64]


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Wrench(IdlStruct, typename="geometry_msgs::msg::dds_::Wrench_"):
    force: Vector3
    torque: Vector3


@dataclass
class WrenchStamped(IdlStruct, typename="geometry_msgs::msg::dds_::WrenchStamped_"):
    header: Header
    wrench: Wrench


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


# Services of rmw_cyclonedds begin with the client and the number of the request; a reply repeats both.
@dataclass
class Call(IdlStruct, typename="vibrissa_tests::Call_"):
    client: array[uint8, 8]
    high: int32
    low: uint32


@dataclass
class Goal(IdlStruct, typename="vibrissa_msgs::action::dds_::TouchTest_Goal_"):
    test_id: str
    array: str
    whisker: uint16
    kind: uint8
    distances_m: sequence[float64]
    deflections_m: sequence[float64]
    contacts: uint16


@dataclass
class SendGoalRequest(IdlStruct, typename="vibrissa_msgs::action::dds_::TouchTest_SendGoal_Request_"):
    call: Call
    goal_id: array[uint8, 16]
    goal: Goal


@dataclass
class SendGoalResponse(IdlStruct, typename="vibrissa_msgs::action::dds_::TouchTest_SendGoal_Response_"):
    call: Call
    accepted: bool
    stamp: Time


@dataclass
class GetResultRequest(IdlStruct, typename="vibrissa_msgs::action::dds_::TouchTest_GetResult_Request_"):
    call: Call
    goal_id: array[uint8, 16]


@dataclass
class Result(IdlStruct, typename="vibrissa_msgs::action::dds_::TouchTest_Result_"):
    contacts: sequence[Contact]
    problem: str


@dataclass
class GetResultResponse(IdlStruct, typename="vibrissa_msgs::action::dds_::TouchTest_GetResult_Response_"):
    call: Call
    status: int8
    result: Result


# Services of parameters, as other implementations carry them: without the call.
@dataclass
class GetParametersRequest(IdlStruct, typename="rcl_interfaces::srv::dds_::GetParameters_Request_"):
    names: sequence[str]


@dataclass
class ParameterValue(IdlStruct, typename="rcl_interfaces::msg::dds_::ParameterValue_"):
    type: uint8
    bool_value: bool
    integer_value: int64
    double_value: float64
    string_value: str
    byte_array_value: sequence[uint8]
    bool_array_value: sequence[bool]
    integer_array_value: sequence[int64]
    double_array_value: sequence[float64]
    string_array_value: sequence[str]


@dataclass
class GetParametersResponse(IdlStruct, typename="rcl_interfaces::srv::dds_::GetParameters_Response_"):
    values: sequence[ParameterValue]


@dataclass
class Transition(IdlStruct, typename="lifecycle_msgs::msg::dds_::Transition_"):
    id: uint8
    label: str


@dataclass
class State(IdlStruct, typename="lifecycle_msgs::msg::dds_::State_"):
    id: uint8
    label: str


@dataclass
class TransitionEvent(IdlStruct, typename="lifecycle_msgs::msg::dds_::TransitionEvent_"):
    timestamp: uint64
    transition: Transition
    start_state: State
    goal_state: State


@dataclass
class ChangeStateRequest(IdlStruct, typename="lifecycle_msgs::srv::dds_::ChangeState_Request_"):
    call: Call
    transition: Transition


@dataclass
class ChangeStateResponse(IdlStruct, typename="lifecycle_msgs::srv::dds_::ChangeState_Response_"):
    call: Call
    success: bool


@dataclass
class GetStateRequest(IdlStruct, typename="lifecycle_msgs::srv::dds_::GetState_Request_"):
    call: Call
    structure_needs_at_least_one_member: uint8


@dataclass
class GetStateResponse(IdlStruct, typename="lifecycle_msgs::srv::dds_::GetState_Response_"):
    call: Call
    current_state: State
