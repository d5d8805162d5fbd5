//! Touch tests: each order of the agent is a goal for the action that the user's node serves.

use crate::bridge::Input;
use crate::messages::{Contact, TouchTestGoal, TouchTestResult};

/// Time in which the node must be found, and then in which it must answer a goal, seconds.
const ANSWER_S: f64 = 5.0;
/// Time from finding the node to the goal, seconds. The node must find this program, too: DDS drops its answer before.
const SETTLE_S: f64 = 1.0;
/// Time that the agent gives a test, and each of its touches, seconds.
const TEST_S: f64 = 30.0;
const TOUCH_S: f64 = 5.0;

/// Progress of a touch test.
#[derive(Debug, PartialEq)]
pub enum Progress {
    /// The node has accepted it.
    Running,
    /// All touches are done.
    Done {
        /// The contacts, unless the node has published them.
        contacts: Vec<Contact>,
        /// Duration of the test, seconds.
        took_s: f64,
    },
    /// It cannot be finished, for this reason.
    Failed(String),
}

/// The node that serves the action, as this program reaches it.
pub trait ActionServer {
    /// Identifies a request.
    type Request: PartialEq;
    /// Identifies a goal.
    type Goal: Copy;

    /// Whether the node has been discovered.
    fn is_found(&self) -> bool;
    /// Sends a goal.
    ///
    /// # Errors
    /// It cannot be sent; the error is a text.
    fn send(&mut self, goal: TouchTestGoal) -> Result<(Self::Request, Self::Goal), String>;
    /// Asks for the result of an accepted goal.
    ///
    /// # Errors
    /// It cannot be sent; the error is a text.
    fn ask_result(&mut self, goal: Self::Goal) -> Result<Self::Request, String>;
    /// Cancels a goal.
    fn cancel(&mut self, goal: Self::Goal);
    /// The next answer to a goal: whether it is accepted.
    fn answer(&mut self) -> Option<(Self::Request, bool)>;
    /// The next result, and whether the goal has succeeded.
    fn result(&mut self) -> Option<(Self::Request, bool, TouchTestResult)>;
}

enum Phase<S: ActionServer> {
    /// The node is not found yet, or was found at this time, seconds.
    Waiting(TouchTestGoal, Option<f64>),
    /// The goal is sent.
    Asked(S::Request, S::Goal),
    /// The goal is accepted, and its result is requested.
    Running(S::Request, S::Goal),
}

struct UnderWay<S: ActionServer> {
    test_id: String,
    begun_at_s: f64,
    /// Time limit of the phase, and of the test.
    until_s: f64,
    ends_at_s: f64,
    phase: Phase<S>,
}

/// The touch tests under way.
pub struct TouchTests<S: ActionServer> {
    server: S,
    under_way: Vec<UnderWay<S>>,
}

impl<S: ActionServer> TouchTests<S> {
    /// No tests yet.
    pub fn new(server: S) -> Self {
        Self { server, under_way: Vec::new() }
    }

    /// Begins a test.
    pub fn begin(&mut self, now_s: f64, goal: TouchTestGoal) {
        self.under_way.push(UnderWay {
            test_id: goal.test_id.clone(),
            begun_at_s: now_s,
            until_s: now_s + ANSWER_S,
            ends_at_s: now_s + TEST_S + TOUCH_S * f64::from(goal.contacts),
            phase: Phase::Waiting(goal, None),
        });
    }

    /// Handles what the node has answered, and time limits.
    pub fn step(&mut self, now_s: f64) -> Vec<Input> {
        let mut inputs = Vec::new();
        let mut tell = |test_id: &str, progress: Progress| inputs.push(Input::Test(test_id.to_owned(), progress));
        let is_found =
            self.under_way.iter().any(|test| matches!(test.phase, Phase::Waiting(..))) && self.server.is_found();
        let waiting = std::mem::take(&mut self.under_way);
        for mut test in waiting {
            if let Phase::Waiting(_, found_at_s) = &mut test.phase
                && is_found != found_at_s.is_some()
            {
                *found_at_s = is_found.then_some(now_s);
                test.until_s = now_s + ANSWER_S;
            }
            if let Phase::Waiting(goal, Some(found_at_s)) = &test.phase
                && now_s >= found_at_s + SETTLE_S
            {
                match self.server.send(goal.clone()) {
                    Ok((request, goal)) => {
                        test.phase = Phase::Asked(request, goal);
                        test.until_s = now_s + ANSWER_S;
                    }
                    Err(problem) => {
                        tell(&test.test_id, Progress::Failed(problem));
                        continue;
                    }
                }
            }
            self.under_way.push(test);
        }
        while let Some((request, is_accepted)) = self.server.answer() {
            let asked = |test: &UnderWay<S>| matches!(&test.phase, Phase::Asked(of, _) if *of == request);
            let Some(at) = self.under_way.iter().position(asked) else { continue };
            let mut test = self.under_way.remove(at);
            let Phase::Asked(_, goal) = test.phase else { continue };
            match is_accepted.then(|| self.server.ask_result(goal)) {
                Some(Ok(request)) => {
                    tell(&test.test_id, Progress::Running);
                    test.phase = Phase::Running(request, goal);
                    test.until_s = test.ends_at_s;
                    self.under_way.push(test);
                }
                Some(Err(problem)) => tell(&test.test_id, Progress::Failed(problem)),
                None => tell(&test.test_id, Progress::Failed("the node has rejected the goal".to_owned())),
            }
        }
        while let Some((request, has_succeeded, result)) = self.server.result() {
            let runs = |test: &UnderWay<S>| matches!(&test.phase, Phase::Running(of, _) if *of == request);
            let Some(at) = self.under_way.iter().position(runs) else { continue };
            let test = self.under_way.remove(at);
            let took_s = now_s - test.begun_at_s;
            tell(
                &test.test_id,
                match has_succeeded {
                    true => Progress::Done { contacts: result.contacts, took_s },
                    false => Progress::Failed(format!("the node has not finished it: {:.200}", result.problem)),
                },
            );
        }
        let (server, under_way) = (&mut self.server, &mut self.under_way);
        under_way.retain(|test| {
            if now_s < test.until_s {
                return true;
            }
            let problem = match test.phase {
                Phase::Waiting(..) => "no node serves the action touch_test",
                Phase::Asked(_, goal) => {
                    server.cancel(goal);
                    "the node does not answer the goal"
                }
                Phase::Running(_, goal) => {
                    server.cancel(goal);
                    "the node has not finished it in time"
                }
            };
            tell(&test.test_id, Progress::Failed(problem.to_owned()));
            false
        });
        inputs
    }
}
