//! The load generator: its messages keep the contract, its whiskers stay ordinary, and all messages arrive.

use std::collections::BTreeSet;
use std::pin::pin;

use clap::Parser;
use proptest::prelude::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::effect::Effect;
use vibrissa_core::robot::event::Link;
use vibrissa_core::robot::{Event, Numbers, Outcome, Params, Robot};
use vibrissa_core::units::Micros;
use vibrissa_edge as edge;
use vibrissa_protocol::{
    BootId, CONTACTS_MAX, ConnectionState, Contacts, Factsheet, Message, Receipt, RobotTopic, decode, encode,
};
use vibrissa_simulator::load::kept::Outbox;
use vibrissa_simulator::load::texts::Texts;
use vibrissa_simulator::load::{self, LoadPlan, robots};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::observer::Observer;
use vibrissa_tests::wait::PATIENCE;

const NOW_US: u64 = 1_795_248_000_123_456;
const BOOT: &str = "load-test";

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    plan: LoadPlan,
}

fn plan(arguments: &[&str]) -> LoadPlan {
    let plan = Line::parse_from([&["load", "--fleet", "f"], arguments].concat()).plan;
    plan.check().unwrap();
    plan
}

fn said(plan: &LoadPlan, kind: RobotTopic, payload: &[u8]) -> Message {
    decode(&kind.of(&plan.fleet, &plan.robot(3)), payload).unwrap()
}

/// An ordinary contacts message of the fourth robot.
fn contacts(plan: &LoadPlan, texts: &Texts, seq: u64) -> (Contacts, Vec<u8>) {
    let mut payload = Vec::new();
    texts.ordinary(&mut payload, (3, seq), NOW_US + seq, plan.contacts);
    let Message::Contacts(contacts) = said(plan, RobotTopic::Contacts, &payload) else { panic!("no contacts") };
    (contacts, payload)
}

fn factsheet(plan: &LoadPlan) -> Factsheet {
    let mut robot = robots::Robot::new(plan, 3, &BootId::new(BOOT).unwrap());
    let Message::Factsheet(sheet) = said(plan, RobotTopic::Factsheet, &robot.factsheet(NOW_US)) else {
        panic!("no factsheet")
    };
    sheet
}

#[test]
fn what_robots_of_a_load_say_keeps_the_contract() {
    let plan = plan(&["--whiskers", "50", "--array-whiskers", "24", "--contacts", "20"]);
    let mut robot = robots::Robot::new(&plan, 3, &BootId::new(BOOT).unwrap());
    assert_eq!(robot.level, "whisker/v1/f/r000003/");
    for state in [ConnectionState::Online, ConnectionState::Offline] {
        said(&plan, RobotTopic::Connection, &robot.connection(NOW_US, state));
    }
    let Message::Status(status) = said(&plan, RobotTopic::Status, &robot.status(NOW_US)) else { panic!("no status") };
    let sheet = factsheet(&plan);
    let sizes: Vec<usize> = sheet.arrays.iter().map(|array| array.whiskers.len()).collect();
    assert_eq!((sizes, status.whiskers.len()), (vec![24, 24, 2], 50));

    let texts = Texts::new(&plan, BOOT).unwrap();
    let mut touched = BTreeSet::new();
    for seq in 0..20 {
        let (message, payload) = contacts(&plan, &texts, seq);
        assert_eq!((message.boot_id.as_str(), message.seq, message.contacts.len()), (BOOT, seq, 20));
        assert_eq!(contacts(&plan, &texts, seq).1, payload, "the generator must reproduce the message");
        assert!(message.contacts.is_sorted_by_key(|contact| contact.t_us));
        assert_eq!(message.contacts[19].t_us, NOW_US + seq);
        touched.extend(message.contacts.into_iter().map(|contact| (contact.array, contact.whisker)));
    }
    let there = sheet
        .arrays
        .iter()
        .flat_map(|array| array.whiskers.iter().map(|whisker| (array.array.clone(), whisker.whisker)));
    assert_eq!(touched, there.collect(), "contacts must cover exactly the whiskers of the factsheet");
}

#[test]
fn a_plan_beyond_the_contracts_limits_is_refused() {
    let most = (CONTACTS_MAX + 1).to_string();
    for bad in [["--contacts", &most], ["--robots", "10001"], ["--array-whiskers", "1025"], ["--rate", "0"]] {
        let line = Line::try_parse_from([&["load"], bad.as_slice()].concat());
        assert!(line.is_err() || line.is_ok_and(|line| line.plan.check().is_err()), "{bad:?}");
    }
}

#[test]
fn ordinary_whiskers_of_a_load_stay_ordinary() {
    let plan = plan(&["--whiskers", "10", "--contacts", "20"]);
    let texts = Texts::new(&plan, BOOT).unwrap();
    let params = Params::nguyen_2021(Formulation::Published);
    let mut robot = Robot::new(1, Numbers::default());
    let mut effects = Vec::new();
    let sheet = edge::factsheet(&factsheet(&plan), &["nguyen-2021"]).unwrap();
    robot.step(&params, Micros(NOW_US), &Event::Connection { boot_id: BOOT, link: Link::Online }, &mut effects);
    robot.step(&params, Micros(NOW_US), &Event::Factsheet { boot_id: BOOT, factsheet: &sheet }, &mut effects);
    for seq in 0..2000 {
        let (message, _) = contacts(&plan, &texts, seq);
        let touches: Vec<_> = message.contacts.iter().map(|contact| edge::contact(contact).unwrap()).collect();
        let event = Event::Contacts { boot_id: BOOT, seq, contacts: &touches, missed: &[] };
        assert_eq!(robot.step(&params, Micros(NOW_US + seq), &event, &mut effects), Outcome::Taken);
    }
    let is_called = |effect: &&Effect| matches!(effect, Effect::Trim(_) | Effect::Alarm { .. } | Effect::Command(_));
    let called: Vec<&Effect> = effects.iter().filter(is_called).collect();
    assert!(called.is_empty(), "in 40,000 contacts: {called:?}");
}

/// Records which messages have arrived, for receipts.
#[derive(Default)]
struct Receiver {
    arrived: BTreeSet<u64>,
}

impl Receiver {
    fn receipt(&self, boot_id: &BootId) -> Receipt {
        let next = self.arrived.iter().zip(0..).take_while(|&(&seq, expected)| seq == expected).count() as u64;
        let held = self.arrived.range(next..).map(|&seq| (seq, seq)).take(64).collect();
        Receipt { boot_id: BootId::new("s").unwrap(), seq: 0, robot_boot_id: boot_id.clone(), next, held }
    }
}

#[tokio::test]
async fn a_load_ends_when_all_of_it_is_receipted_although_messages_are_overlooked() {
    let broker = Mosquitto::start();
    let mut observer = Observer::connect(broker.port(), "observer").await;
    let url = format!("mqtt://127.0.0.1:{}", broker.port());
    let shape = ["--robots", "1", "--connections", "1", "--messages", "300", "--unreceipted", "100", "--qos", "0"];
    let plan = plan(&[&["--mqtt-url", url.as_str()], shape.as_slice()].concat());
    let mut load = pin!(load::run(plan, || ()));
    let mut receiver = Receiver::default();
    let mut overlooked = BTreeSet::new();
    let report = loop {
        let heard = tokio::select! {
            report = &mut load => break report.unwrap(),
            heard = observer.next(PATIENCE) => heard.expect("a robot sends until all is receipted"),
        };
        let Message::Contacts(contacts) = heard.message else { continue };
        if contacts.seq % 7 == 3 && overlooked.insert(contacts.seq) {
            continue;
        }
        receiver.arrived.insert(contacts.seq);
        let receipt = encode(&receiver.receipt(&contacts.boot_id));
        observer.publish("whisker/v1/f/r000000/receipt", receipt, false).await;
    };
    // One further contact belongs to the preparation.
    assert_eq!((report.sent, report.receipted, report.contacts_in_all), (300, 300, 301));
    assert_eq!(receiver.arrived, (0..301).collect());
    assert!(report.sent_again >= 300 / 7, "{}", report.sent_again);
}

/// MQTT 3.1.1 does not tell whether a broker retains messages, and such a broker closes the connection of who asks it to.
#[tokio::test]
async fn a_load_without_retained_messages_suits_a_broker_that_retains_none() {
    let broker = Mosquitto::builder().line("retain_available false").start();
    let url = format!("mqtt://127.0.0.1:{}", broker.port());
    let shape = ["--robots", "2", "--messages", "20", "--no-receipts"];
    let run = async |more: &[&str]| {
        let plan = plan(&[&["--mqtt-url", url.as_str()], shape.as_slice(), more].concat());
        load::run(plan, || ()).await
    };
    assert!(run(&[]).await.is_err(), "the broker takes no retained message");
    assert_eq!(run(&["--no-retained"]).await.unwrap().sent, 20);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Messages and receipts may be lost as long as some pass: every message is receipted in the end. No receipted
    /// message is sent again, and no message is sent again within a second.
    #[test]
    fn property_whatever_is_lost_everything_is_receipted_in_the_end(
        count in 1_u64..400,
        seed in any::<u64>(),
        lost in 0.0..0.8_f64,
    ) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut is_lost = || random.random_bool(lost);
        let boot_id = BootId::new(BOOT).unwrap();
        let (mut outbox, mut receiver) = (Outbox::default(), Receiver::default());
        let mut sent_us = vec![NOW_US; count as usize];
        for seq in 0..count {
            outbox.keep(NOW_US, None);
            if !is_lost() {
                receiver.arrived.insert(seq);
            }
        }
        let mut covered = BTreeSet::new();
        let mut now_us = NOW_US;
        while outbox.uncovered() > 0 {
            now_us += 100_000;
            prop_assert!(now_us < NOW_US + 20_000_000_000, "{} messages without a receipt", outbox.uncovered());
            if !is_lost() {
                let receipt = receiver.receipt(&boot_id);
                covered.extend((0..count).filter(|&seq| receipt.covers(seq)));
                outbox.receipt(now_us, receipt.next, &receipt.held);
            }
            prop_assert_eq!(outbox.uncovered() as u64, count - covered.len() as u64);
            let again = outbox.resend(now_us);
            prop_assert!(again.is_sorted());
            for seq in again {
                prop_assert!(!covered.contains(&seq));
                prop_assert!(sent_us[seq as usize] + 1_000_000 <= now_us);
                sent_us[seq as usize] = now_us;
                if !is_lost() {
                    receiver.arrived.insert(seq);
                }
            }
        }
    }
}
