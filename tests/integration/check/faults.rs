//! For each rule, a robot that breaks it.

use std::rc::Rc;

use tokio::sync::Semaphore;
use tokio::task::{JoinSet, LocalSet};
use vibrissa::check::{Outcome, Report};
use vibrissa_protocol::{Rule, SupervisorPresence};
use vibrissa_simulator::Broker;
use vibrissa_simulator::scenario::Misbehaviour;
use vibrissa_tests::mosquitto::Mosquitto;

use super::{checked, robot_of, supervisor_of};

/// Number of robots that are checked at the same time.
const AT_A_TIME: usize = 48;

async fn report(broker: &Mosquitto, fault: Option<Misbehaviour>) -> Report {
    let name = fault.map_or("honest", Misbehaviour::as_str);
    // A fleet for each: a request for births reaches all robots of a fleet, and their answers would hide faults.
    let own = format!("fleet-{name}");
    supervisor_of(&own, broker, SupervisorPresence::Offline).await;
    let address = Broker::new("127.0.0.1", broker.port());
    let (fleet, robot) = robot_of(&address, &own, name, fault).await;
    let report = checked(broker, &robot).await;
    fleet.stop().await;
    report
}

/// The problem of a report, if any.
fn complaint(fault: Option<Misbehaviour>, report: &Report) -> Option<String> {
    let broken: Vec<Rule> = fault.and_then(Misbehaviour::rule).into_iter().collect();
    let mut problems = Vec::new();
    if report.rules(Outcome::Fail) != broken {
        problems.push(format!("failed {:?} instead of {broken:?}", report.rules(Outcome::Fail)));
    }
    let untested: Vec<Rule> = report.rules(Outcome::Skipped).into_iter().filter(|rule| rule.is_testable()).collect();
    if fault.is_none() && !untested.is_empty() {
        problems.push(format!("skipped {untested:?}"));
    }
    let told = || format!("{}: {}\n{report}", fault.map_or("honest", Misbehaviour::as_str), problems.join("; "));
    (!problems.is_empty()).then(told)
}

#[tokio::test(flavor = "multi_thread")]
async fn the_simulator_passes_and_each_planted_fault_fails_its_rule_alone() {
    // The checks wait on this thread; robots and connections use the other threads.
    let complaints = LocalSet::new().run_until(complaints()).await;
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

async fn complaints() -> Vec<String> {
    let broker = Rc::new(Mosquitto::start());
    let places = Rc::new(Semaphore::new(AT_A_TIME));
    let mut checks = JoinSet::new();
    let faults = Misbehaviour::ALL.iter().copied().filter(|fault| fault.rule().is_some());
    for fault in std::iter::once(None).chain(faults.map(Some)) {
        let (broker, places) = (broker.clone(), places.clone());
        checks.spawn_local(async move {
            let _place = places.acquire().await.unwrap();
            (fault, report(&broker, fault).await)
        });
    }
    let mut complaints = Vec::new();
    while let Some(done) = checks.join_next().await {
        let (fault, report) = done.unwrap();
        if fault.is_none() {
            println!("{report}");
        }
        println!("{:28} {:5.1} s", fault.map_or("honest", Misbehaviour::as_str), report.seconds);
        complaints.extend(complaint(fault, &report));
    }
    complaints
}
