//! A touch test as an action, between the program's client and a server of the same library, in both forms of services.

use std::net::{IpAddr, Ipv4Addr};
use std::sync::mpsc::sync_channel;
use std::thread;
use std::time::{Duration, Instant};

use futures::executor::block_on;
use ros2_client::action::{
    ActionServerQosPolicies, GetResultResponse, GoalStatusEnum, SendGoalRequest, SendGoalResponse,
};
use ros2_client::builtin_interfaces::Time;
use ros2_client::qos::{Durability, History};
use ros2_client::{ActionTypeName, Context, Name, NodeName, NodeOptions, QosProfile, ServiceMapping};
use rustdds::DomainParticipantBuilder;
use vibrissa_ros2::bridge::Input;
use vibrissa_ros2::messages::{Contact, Header, TouchTestFeedback, TouchTestGoal, TouchTestResult};
use vibrissa_ros2::node::{NodeScope, RosNode};
use vibrissa_ros2::remap::Names;
use vibrissa_ros2::touch::{Progress, TouchTests};

/// Domains whose ports are below those that Linux gives to clients.
const DOMAINS: u32 = 100;
const PATIENCE: Duration = Duration::from_secs(60);
const TICK: Duration = Duration::from_millis(20);
/// Real time in a second of the tests' time, so that a busy machine has the time to discover both sides.
const SLOWER: f64 = 4.0;

fn contact() -> Contact {
    Contact {
        header: Header { stamp: Time::new(1, 2), frame_id: "left/0".to_owned() },
        array: "left".to_owned(),
        whisker: 0,
        deflection_m: 0.0015,
        strain: 0.0102,
        place: 1,
        distance_m: 0.056,
        distance_sd_m: 0.0,
        ratio: 0.0,
        ratio_sd: 0.0,
        test_id: String::new(),
        missed: false,
        saturated: false,
    }
}

fn is_done(services: ServiceMapping, name: &str) {
    let domain = u16::try_from(std::process::id() % DOMAINS).expect("a domain");
    let namespace = format!("/{name}_{}", std::process::id());
    let local = DomainParticipantBuilder::new(domain).with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]);
    let context = Context::from_domain_participant(local.build().expect("DDS")).expect("a context");
    let mut node = context
        .new_node(NodeName::new(&namespace, "arm").expect("a name"), NodeOptions::new().enable_rosout(false))
        .expect("a node");
    let spinner = node.spinner().expect("a spinner");
    thread::spawn(move || block_on(spinner.spin()));
    let qos =
        || QosProfile::publisher_default().durability(Durability::Volatile).history(History::KeepLast { depth: 10 });
    let server = node
        .create_action_server::<TouchTestGoal, TouchTestResult, TouchTestFeedback>(
            services,
            &Name::new(&namespace, "touch_test").expect("a name"),
            &ActionTypeName::new("vibrissa_msgs", "TouchTest"),
            ActionServerQosPolicies {
                goal_service: qos(),
                result_service: qos(),
                cancel_service: qos(),
                feedback_publisher: qos(),
                status_publisher: qos(),
            },
        )
        .expect("a server");

    let (inputs, receive) = sync_channel(100);
    let names = Names::new(&namespace, "vibrissa", Vec::new()).expect("names");
    let scope = NodeScope { domain, is_local: true, names, services, parameters: Vec::new() };
    let mut bridge = RosNode::join(scope, inputs).expect("the bridge's node");
    let mut tests = TouchTests::new(bridge.open(vec!["left/whisker_0".to_owned()], None).expect("topics"));
    let order = TouchTestGoal {
        test_id: "t1".to_owned(),
        array: "left".to_owned(),
        whisker: 0,
        kind: 2,
        distances_m: vec![0.056, 0.063],
        deflections_m: vec![0.0015],
        contacts: 2,
    };
    tests.begin(0.0, order.clone());
    let (begun, mut heard) = (Instant::now(), Vec::new());
    while heard.len() < 2 {
        assert!(begun.elapsed() < PATIENCE, "{services:?}: {heard:?}");
        while let Ok(Some((request, SendGoalRequest { goal, .. }))) = server.receive_goal() {
            assert_eq!(goal, order);
            server.send_goal_response(request, SendGoalResponse { accepted: true, stamp: Time::now() }).expect("sent");
        }
        while let Ok(Some((request, _))) = server.receive_result_request() {
            let result = TouchTestResult { contacts: vec![contact()], problem: String::new() };
            server.send_result(request, GetResultResponse { status: GoalStatusEnum::Succeeded, result }).expect("sent");
        }
        for input in tests.step(begun.elapsed().as_secs_f64() / SLOWER) {
            let Input::Test(id, progress) = input else { panic!("{input:?}") };
            heard.push((id, progress));
        }
        let _ = receive.recv_timeout(TICK);
    }
    let [(_, Progress::Running), (id, Progress::Done { contacts, .. })] = &heard[..] else { panic!("{heard:?}") };
    assert_eq!((id.as_str(), &contacts[..]), ("t1", &[contact()][..]));
}

#[test]
fn a_goal_and_its_result_cross_dds_as_with_fast_dds() {
    is_done(ServiceMapping::Enhanced, "enhanced");
}

#[test]
fn a_goal_and_its_result_cross_dds_as_with_cyclone_dds() {
    is_done(ServiceMapping::Cyclone, "cyclone");
}
