//! For each rule, a robot that breaks it.

use std::rc::Rc;

use tokio::sync::Semaphore;
use tokio::task::{JoinSet, LocalSet};
use vibrissa_lab::check::{Outcome, Report};
use vibrissa_protocol::{OnSupervisorLoss, Rule};
use vibrissa_simulator::places::Places;
use vibrissa_simulator::scenario::{Misbehaviour, Scenario};
use vibrissa_tests::mosquitto::Mosquitto;

use super::helper::assisted;
use super::scenario_of;

/// Number of robots that are checked at the same time.
const AT_A_TIME: usize = 64;
/// Rules about estimates, which do not concern a robot that knows its lengths.
const ESTIMATES: [Rule; 2] = [Rule::EstimateOrder, Rule::EstimateLength];

/// A robot to check.
#[derive(Debug, Clone, Copy)]
struct Case {
    fault: Option<Misbehaviour>,
    places: Places,
    on_supervisor_loss: OnSupervisorLoss,
}

impl Case {
    fn new(fault: Option<Misbehaviour>, places: Places) -> Self {
        Self { fault, places, on_supervisor_loss: OnSupervisorLoss::Hold }
    }

    fn of_fault(fault: Misbehaviour) -> Self {
        let divides = fault.rule().is_some_and(|rule| ESTIMATES.contains(&rule));
        Self::new(Some(fault), if divides { Places::EstimatedRatio } else { Places::Ratio })
    }

    /// Robots without a fault: they behave differently without a supervisor, and know different places.
    fn honest() -> [Self; 4] {
        let honest = Self::new(None, Places::EstimatedRatio);
        [
            honest,
            Self { on_supervisor_loss: OnSupervisorLoss::Nominal, ..Self::new(None, Places::Ratio) },
            Self { on_supervisor_loss: OnSupervisorLoss::Vent, ..honest },
            Self::new(None, Places::Distance),
        ]
    }

    fn name(self) -> String {
        let honest = || format!("honest-{:?}-{}", self.places, self.on_supervisor_loss);
        self.fault.map_or_else(honest, |fault| fault.as_str().to_owned())
    }

    /// A fleet for each: a request for births reaches all robots of a fleet, and their answers would hide faults.
    fn scenario(self) -> Scenario {
        let mut scenario = scenario_of(&format!("fleet-{}", self.name()), &self.name(), self.fault);
        scenario.behaviour.places = self.places;
        scenario.robots[0].on_supervisor_loss = self.on_supervisor_loss;
        scenario
    }

    /// The problem of a report, if any.
    fn complaint(self, report: &Report) -> Option<String> {
        let broken: Vec<Rule> = self.fault.and_then(Misbehaviour::rule).into_iter().collect();
        let mut problems = Vec::new();
        if report.rules(Outcome::Fail) != broken {
            problems.push(format!("failed {:?} instead of {broken:?}", report.rules(Outcome::Fail)));
        }
        if self.fault.is_none() {
            let skipped = report.rules(Outcome::Skipped);
            if !skipped.is_empty() {
                problems.push(format!("skipped {skipped:?}"));
            }
            let exempt = if self.places == Places::EstimatedRatio { Vec::new() } else { ESTIMATES.to_vec() };
            if report.rules(Outcome::Exempt) != exempt {
                problems.push(format!("exempt from {:?} instead of {exempt:?}", report.rules(Outcome::Exempt)));
            }
        }
        let summary = || format!("{}: {}\n{report}", self.name(), problems.join("; "));
        (!problems.is_empty()).then(summary)
    }
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
    for case in Case::honest().into_iter().chain(faults.map(Case::of_fault)) {
        let (broker, places) = (broker.clone(), places.clone());
        checks.spawn_local(async move {
            let _place = places.acquire().await.unwrap();
            (case, assisted(&broker, case.scenario()).await)
        });
    }
    let mut complaints = Vec::new();
    while let Some(done) = checks.join_next().await {
        let (case, report) = done.unwrap();
        if case.fault.is_none() {
            println!("{report}");
        }
        println!("{:28} {:5.1} s", case.name(), report.seconds);
        complaints.extend(case.complaint(&report));
    }
    complaints
}
