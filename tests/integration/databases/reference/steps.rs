//! Steps: what an owner asks of its database.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use vibrissa_protocol::Name;
use vibrissa_simulation::store::ModelStore;
use vibrissa_store::actions::{Action, Asked, NewAction};
use vibrissa_store::allowed::TurnedAwayReading;
use vibrissa_store::batch::Record;
use vibrissa_store::black_boxes::NewBlackBox;
use vibrissa_store::calibrations::NewCalibration;
use vibrissa_store::refusals::RefusalRow;
use vibrissa_store::{Batch, LogPositions, StoredRobot};
use vibrissa_tests::actions::asks;

use super::subject::{Behind, KnownRobot, NOBODY, Subject};
use super::{batches, text, webhooks};
use crate::rows;

/// Takes a step, and tells it with the answers.
pub(super) async fn step(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    match random.random_range(0..54) {
        0..3 => register(subject, random).await,
        3..6 => lay_out(subject, random).await,
        6 => boot(subject, random).await,
        7..20 => commit(subject, random).await,
        20..23 => robots(subject, random).await,
        23 => journal(subject, random).await,
        24 => positions(subject, random).await,
        25..28 => request(subject, random).await,
        28 => actions(subject, random).await,
        29 => allowed(subject, random).await,
        30 => noted(subject, random).await,
        31 => black_boxes(subject, random).await,
        32..35 => settings(subject).await,
        35 => calibrate(subject).await,
        36..39 => errors(subject, random).await,
        39 => former(subject).await,
        40 => decommission(subject, random).await,
        41 => dispossessed(subject, random).await,
        _ => webhooks::step(subject, random).await,
    }
}

async fn register(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let (name, boot_id) = (format!("r{}", random.random_range(0..4)), format!("b{}", random.random_range(0..3)));
    let now_us = subject.tick();
    let answer = subject.writer.register(&subject.lease, (&name, &boot_id), now_us).await;
    let robot_id = answer.as_ref().ok().and_then(Option::as_ref).map(|one| one.robot_id);
    if let Some(robot_id) = robot_id.filter(|id| subject.place(*id).is_none()) {
        let (core, whiskers) = (rows::known(1, 1), Vec::new());
        subject.robots.push(KnownRobot { name: name.clone(), robot_id, core, whiskers, drawn: 0 });
    }
    let place = robot_id.map(|id| subject.place(id));
    let numbers = text(answer.map(|registered| registered.map(|one| one.numbers)));
    format!("register {name} {boot_id}: {place:?} {numbers}")
}

/// A new factsheet with one to three whiskers, as the engine writes it.
async fn lay_out(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let Some(at) = subject.any_robot(random) else { return "no robot to lay out".to_owned() };
    let count = random.random_range(1..4);
    let core = rows::known(1, count);
    let answer = subject.writer.whisker_ids(&subject.lease, subject.robots[at].robot_id, &core).await;
    let ids: Vec<i64> = answer.iter().flatten().map(|(id, _)| *id).collect();
    let robot = &mut subject.robots[at];
    let gone: Vec<i64> = robot.whiskers.iter().skip(ids.len()).copied().collect();
    robot.whiskers = ids.iter().chain(&gone).copied().collect();
    robot.core = core;
    let rollups = text(answer.map(|all| all.into_iter().map(|(_, rollup)| rollup).collect::<Vec<_>>()));
    let batch = batches::layout(subject, at, &gone);
    let written = text(subject.commit(&batch, random.random_bool(0.1)).await);
    format!("lay out robot {at} with {count} whiskers: {rollups} {written}")
}

async fn boot(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let at = subject.any_robot(random);
    let robot_id = at.map_or(NOBODY, |at| subject.robots[at].robot_id);
    let (boot_id, now_us) = (format!("b{}", random.random_range(0..3)), subject.tick());
    let answer = subject.writer.boot(&subject.lease, robot_id, &boot_id, now_us).await;
    if let Some(boot) = answer.as_ref().ok().filter(|boot| !subject.boots.contains(boot)) {
        subject.boots.push(*boot);
    }
    let place = answer.map(|boot| subject.boots.iter().position(|known| *known == boot));
    format!("boot {boot_id} of robot {at:?}: {}", text(place))
}

async fn commit(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let mut batch = batches::draw(subject, random);
    let loses_answer = random.random_bool(0.2);
    let mut answer = text(subject.commit(&batch, loses_answer).await);
    if answer.starts_with("refused") {
        answer = format!("{answer}; apart {}", subject.commit_apart(&mut batch, loses_answer).await);
    }
    let (records, journal) = (batch.records.len(), batch.journal.as_ref().map(|row| row.number));
    format!("commit {records} records, journal {journal:?}, lost {loses_answer}: {answer}")
}

fn told(subject: &Subject, robot: &StoredRobot) -> String {
    let whiskers: Vec<_> = robot.whisker_ids.iter().map(|id| subject.whisker_place(*id)).collect();
    let boots = robot.boots.iter().map(|(id, boot)| (id, subject.boots.iter().position(|known| known == boot)));
    let StoredRobot { robot_id, robot: name, state, whisker_states, rollups, journal_number, held, numbers, .. } =
        robot;
    let (place, boots) = (subject.place(*robot_id), boots.collect::<Vec<_>>());
    let told = (&robot.software, &robot.segmenters);
    format!(
        "{place:?} {name} {whiskers:?} {boots:?} {journal_number} {held} {numbers:?} {state:?} {whisker_states:?} \
         {rollups:?} {told:?}"
    )
}

async fn robots(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let at = subject.any_robot(random);
    let after = at.filter(|_| random.random_bool(0.5)).map_or(0, |at| subject.robots[at].robot_id);
    let most = random.random_range(1..5);
    let some = subject.writer.robots(&subject.lease, after, most).await.unwrap();
    let last = some.last.map(|id| subject.place(id));
    let all: Vec<String> = some.robots.iter().map(|robot| told(subject, robot)).collect();
    let robot_id = at.map_or(NOBODY, |at| subject.robots[at].robot_id);
    let one = subject.writer.robot(&subject.lease, robot_id).await.unwrap();
    let one = one.map(|robot| told(subject, &robot));
    format!("{most} robots after {at:?}: {last:?} {all:?}; robot {at:?}: {one:?}")
}

async fn journal(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let (after, most) = (random.random_range(-1..=subject.journal), random.random_range(1..20));
    format!("{most} of the journal after {after}: {}", text(subject.writer.journal(&subject.lease, after, most).await))
}

async fn positions(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let mut told = String::new();
    if random.random_bool(0.3) {
        let positions = LogPositions { topic: "one".into(), next: [(7, subject.journal)].into() };
        told += &text(subject.writer.set_log_positions(&subject.lease, &positions).await);
    }
    for topic in ["one", "two", "three"] {
        told += &text(subject.writer.log_positions(&subject.lease, topic).await);
    }
    format!("positions {told}")
}

async fn request(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let robot = subject.any_robot(random).filter(|_| random.random_bool(0.7)).map(|at| subject.robots[at].name.clone());
    let (asked_us, fleet) = (subject.tick(), Some(subject.fleet().to_string()));
    let action = NewAction { fleet, robot, asked_us, expires_us: asked_us + 1, ..asks("HOLD", "{}") };
    let action_id = match &subject.behind {
        Behind::Model(at_hand) => at_hand.store().request_action(&action),
        Behind::Database(_) => number(subject.store.ask(&action).await.unwrap()),
    };
    subject.actions.push(action_id);
    format!("request action {} of {:?}", subject.actions.len(), action.robot)
}

fn number(asked: Asked) -> i64 {
    let Asked::New(action_id) = asked else { panic!("{asked:?}") };
    action_id
}

async fn actions(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let most = random.random_range(1..6);
    let without =
        subject.any_robot(random).filter(|_| random.random_bool(0.3)).map(|at| subject.robots[at].name.clone());
    let without: Vec<Name> = without.and_then(|name| Name::new(&name).ok()).into_iter().collect();
    let pending = subject.writer.pending(&subject.lease, most, &without).await.unwrap();
    let one = subject.any_action(random);
    let one = subject.store.action(one).await.unwrap();
    let place = |id| subject.actions.iter().position(|known| *known == id);
    let told =
        |action: &Action| format!("{:?} {:?}", place(action.action_id), Action { action_id: 0, ..action.clone() });
    let pending: Vec<String> = pending.actions.iter().map(told).collect();
    let (work, fleet) = (subject.store.fleets_with_work(i64::MAX).await.unwrap(), subject.fleet());
    let work = work.into_iter().find(|work| work.fleet == fleet.as_str());
    format!("{most} actions: {pending:?}; one: {:?}; work: {work:?}", one.as_ref().map(told))
}

async fn allowed(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let before = subject.writer.allowed_robots(&subject.lease, 0).await.unwrap().map_or(0, |list| list.version);
    let names = random.random_bool(0.7).then(|| format!("r0\nr{}", random.random_range(0..9)));
    if random.random_bool(0.5) {
        let fleet = subject.fleet();
        match &subject.behind {
            Behind::Model(at_hand) => at_hand.store().allow_robots(&fleet, names.as_deref()),
            Behind::Database(_) => {
                let action = asks("ALLOW", "{}");
                let set = subject.store.set_allowed_robots(fleet.as_str(), before, names.as_deref(), &action).await;
                number(set.unwrap().unwrap());
            }
        }
    }
    let after = random.random_range(0..=before + 1);
    let list = subject.writer.allowed_robots(&subject.lease, after).await;
    format!("allowed after {after}: {}", text(list.map(|list| list.map(|list| (list.version, list.robots)))))
}

/// What people read only.
async fn noted(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let at = subject.any_robot(random);
    let (robot_id, refused_us) = (at.map_or(NOBODY, |at| subject.robots[at].robot_id), subject.tick());
    let (topic, reason, problem) = ("contacts", "bad", "no number".to_owned());
    let row = RefusalRow { robot_id, topic, reason, refused: 1, refused_us, problem };
    let refusals = text(subject.writer.add_refusals(&subject.lease, &[row.clone(), row]).await);
    let row = TurnedAwayReading { robot: "x".to_owned(), tries: 2, first_us: 1, last_us: 2 };
    let turned_away = text(subject.writer.write_turned_away(&subject.lease, &[row]).await);
    let horizon_us = random.random_range(0..100);
    let horizon = text(subject.writer.state_horizon(&subject.lease, horizon_us).await);
    let floor = text(subject.writer.archive_floor(&subject.fleet()).await);
    format!("refusals of {at:?} {refusals}, turned away {turned_away}, horizon {horizon_us}: {horizon} {floor}")
}

async fn black_boxes(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let at = subject.any_robot(random);
    let robot = at.map(|at| &subject.robots[at]);
    let (robot_id, whisker) =
        (robot.map_or(NOBODY, |robot| robot.robot_id), robot.and_then(|one| one.whiskers.first()));
    let one = NewBlackBox {
        robot_id,
        whisker_id: whisker.copied().unwrap_or(NOBODY),
        cause: "TRIM",
        event_us: random.random_range(0..5),
        began_us: 0,
        ends_us: 9,
        last_us: 5,
        state: "RECORDING",
        messages: 3,
        left_out: 0,
        has_state: true,
        bytes: 10,
        body: vec![1],
    };
    let written = text(subject.writer.write_black_box(&subject.lease, &one).await);
    format!("box of {at:?}: {written} {}", text(subject.writer.end_black_boxes(&subject.lease).await))
}

async fn settings(subject: &mut Subject) -> String {
    let (writer, lease) = (&mut subject.writer, &subject.lease);
    let (policy, version) = (writer.policy(lease).await.unwrap(), writer.policy_version(lease).await.unwrap());
    let (rollout, active) = (writer.open_rollout(lease).await.unwrap(), writer.calibrations(lease).await.unwrap());
    let place = |id: i64| subject.actions.iter().position(|known| *known == id);
    let policy = policy.map(|mut policy| (place(std::mem::take(&mut policy.action_id)), policy));
    let rollout = rollout.map(|mut rollout| (place(std::mem::take(&mut rollout.rollout_id)), rollout));
    let number = |id: i64| subject.calibrations.iter().position(|known| *known == id);
    let active: Vec<_> = active.into_iter().map(|one| (number(one.calibration_id), one.calibration)).collect();
    format!("policy {version} {policy:?}; roll-out {rollout:?}; calibrations {active:?}")
}

async fn calibrate(subject: &mut Subject) -> String {
    let calibration = format!("{{\"of\": {}}}", subject.calibrations.len());
    let calibration_id = match &subject.behind {
        Behind::Model(at_hand) => ModelStore::add_calibration(&mut at_hand.store(), &calibration),
        Behind::Database(_) => {
            let [model, measurements, fit] = ["m", "[]", "{}"].map(str::to_owned);
            let new = NewCalibration { model, measurements, fit, calibration };
            subject.store.add_calibration(&new, &asks("UPLOAD", "{}")).await.unwrap().1.unwrap()
        }
    };
    subject.calibrations.push(calibration_id);
    format!("calibration {}", subject.calibrations.len())
}

async fn errors(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let since_us = subject.tick() - random.random_range(0..5_000_000_000);
    let errors = subject.writer.errors_since(&subject.lease, since_us).await.unwrap();
    let errors: Vec<_> = errors.iter().map(|one| format!("{} {:.9}", one.robot, one.error)).collect();
    let silent = subject.writer.robots_with_alarm(&subject.lease, "ROBOT_SILENT").await.unwrap();
    let mut silent: Vec<_> = silent.into_iter().map(|id| subject.place(id)).collect();
    silent.sort_unstable();
    format!("errors {errors:?}, alarms {silent:?}")
}

/// What a supervisor asks before it takes up a fleet.
async fn former(subject: &mut Subject) -> String {
    let (fleet, store) = (subject.fleet(), &subject.store);
    let mut known = vec![store.has_robots(&fleet).await.unwrap()];
    for epoch in [0, subject.lost.epoch() - 1, subject.lost.epoch(), subject.lease.epoch()] {
        known.push(store.has_epoch_until(&fleet, epoch).await.unwrap());
    }
    store.follow_events(fleet.as_str(), 1).await.unwrap();
    store.ping().await.unwrap();
    format!("former owners {known:?}")
}

async fn decommission(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let Some(at) = subject.any_robot(random) else { return "no robot to decommission".to_owned() };
    let now_us = subject.tick();
    let record = Record::Decommissioned { robot_id: subject.robots[at].robot_id, left_us: now_us };
    let batch = Batch { records: vec![record], ..Batch::default() };
    let answer = subject.writer.commit(&subject.lease, &batch).await.map(drop);
    format!("decommission robot {at}: {}", text(answer))
}

async fn dispossessed(subject: &mut Subject, random: &mut ChaCha8Rng) -> String {
    let Some(at) = subject.any_robot(random) else { return "no robot of a former owner".to_owned() };
    let (batch, now_us) = (batches::draw(subject, random), subject.tick());
    let Subject { writer, lost, robots, .. } = subject;
    let robot_id = robots[at].robot_id;
    let mut told = vec![
        text(writer.register(lost, ("new", "b"), now_us).await.map(drop)),
        text(writer.boot(lost, robot_id, "new", now_us).await.map(drop)),
        text(writer.whisker_ids(lost, robot_id, &robots[at].core).await.map(drop)),
        text(writer.state_horizon(lost, i64::MAX).await),
        text(writer.write_turned_away(lost, &[]).await),
        text(writer.end_black_boxes(lost).await),
        text(writer.add_refusals(lost, &[]).await),
        text(writer.release(lost).await),
    ];
    let contacts = Batch { contacts: batch.contacts, log: batch.log, ..Batch::default() };
    told.push(text(writer.commit(lost, &contacts).await));
    format!("a former owner: {told:?}")
}
