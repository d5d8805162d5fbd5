//! The begin and the end of each fault.

use std::time::Duration;

use rand::seq::IndexedRandom as _;
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rumqttc::QoS;
use tokio::time::sleep;
use vibrissa_simulator::Robot;
use vibrissa_store::actions::NewAction;

use super::{World, locked};
use crate::broker::{Client, ClientOptions, Delay, Memory, Way};
use crate::log::{PARTITIONS, TOPIC};
use crate::member::Member;
use crate::plan::{Kind, Strike};
use crate::receivers::Manner;
use crate::robots::SimulatedRobot;

/// An hour in µs.
const HOUR_US: i64 = 3_600_000_000;

impl World {
    fn member(&mut self, strike: &Strike) -> &mut Member {
        let count = self.members.len();
        &mut self.members[strike.victim % count]
    }

    fn robot(&self, strike: &Strike) -> &SimulatedRobot {
        &self.robots[strike.victim % self.robots.len()]
    }

    /// A step of a clock, µs: from a tenth of a second to two hours, either way.
    fn step_us(strike: &Strike) -> i64 {
        let size_us = (100_000.0 * 72_000.0_f64.powf((strike.measure >> 8) as f64 / (1_u64 << 56) as f64)) as i64;
        let size_us = size_us.min(2 * HOUR_US);
        if strike.measure & 1 == 0 { size_us } else { -size_us }
    }

    pub(super) fn begin(&mut self, strike: &Strike) {
        let measure = strike.measure;
        match strike.kind {
            Kind::SupervisorKilled => {
                if let Some(process) = self.member(strike).process() {
                    process.kill_after(measure % 500);
                }
            }
            Kind::SupervisorStopped | Kind::SupervisorUpgraded => self.member(strike).stop(),
            Kind::SupervisorFrozen => {
                if let Some(process) = self.member(strike).process() {
                    process.freeze();
                }
            }
            Kind::HostClockStepped => self.member(strike).host.step(Self::step_us(strike)),
            Kind::ToBrokerCut => self.member(strike).routes.broker.set_cut(Way::ToBroker, true),
            Kind::FromBrokerCut => self.member(strike).routes.broker.set_cut(Way::ToClient, true),
            Kind::BrokerLinkReset => self.member(strike).routes.broker.reset(),
            Kind::SubscriptionsForgotten => {
                let clients = self.broker.clients();
                let receivers: Vec<_> = clients.iter().filter(|client| client.starts_with("vibrissa-")).collect();
                if let Some(client) = receivers.get(strike.victim % receivers.len().max(1)) {
                    self.broker.forget_subscriptions(client);
                }
            }
            Kind::BrokerRestarted => {
                self.broker.set_accepting(false);
                self.broker.restart(Memory::Kept);
            }
            Kind::BrokerReplaced => {
                self.broker.set_accepting(false);
                self.broker.restart(Memory::Lost);
            }
            Kind::BrokerFrozen => self.broker.set_frozen(true),
            Kind::Repetitions => self.broker.set_repetition(0.2),
            Kind::SlowBroker | Kind::TopicsOvertake => {
                let topics_overtake = strike.kind == Kind::TopicsOvertake;
                // A status from before a setpoint is to arrive when its pressure is reached, after some seconds.
                let most_ms = if topics_overtake { 8_000 } else { 3_000 };
                let spread = Duration::from_millis(1 + measure % most_ms);
                self.broker.set_delay(Way::ToClient, Delay { least: Duration::ZERO, spread });
                self.broker.set_topics_overtake(topics_overtake);
            }
            Kind::RobotCut => self.robot(strike).cut(),
            Kind::RobotAway => self.robot(strike).set_off(true),
            Kind::RobotRestarted => self.robot(strike).with(Robot::restart_soon),
            Kind::Hostile => self.hostile(strike),
            Kind::ToStoreCut => self.member(strike).way.cut_requests(true),
            Kind::FromStoreCut => self.member(strike).way.cut_answers(true),
            Kind::AnswersLost => self.member(strike).way.lose_answers(true),
            Kind::StoreSlow => self.server.set_work(Some(Duration::from_millis(20 + measure % 1_500))),
            Kind::StoreAway => self.server.set_up(false),
            Kind::StoreFull => self.server.set_full(true),
            Kind::StoreClockStepped => self.server.clock().step(Self::step_us(strike)),
            Kind::StoreFailover => {
                if self.failover.is_none() {
                    let mut observations = locked(&self.observations);
                    let mut data = self.server.data();
                    observations.record.drain(&self.robots, &mut data);
                    self.failover = Some((data.clone(), observations.record.snapshot()));
                }
            }
            Kind::OperatorHolds => self.act(strike, "HOLD"),
            Kind::ReceiverSlow => {
                self.receivers.set(strike.victim, Manner::Slow(Duration::from_millis(measure % 12_000)));
            }
            Kind::ReceiverFails => self.receivers.set(strike.victim, Manner::Fails),
            Kind::ReceiverSilent => self.receivers.set(strike.victim, Manner::Silent),
            Kind::ReceiverCuts => self.receivers.set(strike.victim, Manner::Cuts),
            Kind::ToLogCut => self.member(strike).routes.log.set_cut(Way::ToBroker, true),
            Kind::FromLogCut => self.member(strike).routes.log.set_cut(Way::ToClient, true),
            Kind::LogDown => self.log.set_down(true),
            Kind::LogFrozen => self.log.set_frozen(true),
            Kind::PartitionAway => self.log.set_away(TOPIC, strike.victim % PARTITIONS, true),
            Kind::RecordsRepeated => self.bridge.set_repetition(0.2),
            Kind::RecordsLate => self.bridge.set_delay(Duration::from_millis(1 + measure % 3_000)),
            Kind::RecordsDeleted => {
                let partition = strike.victim % PARTITIONS;
                if let Some((_, end)) = self.log.offsets(TOPIC, partition) {
                    self.log.delete_before(TOPIC, partition, end);
                }
            }
            Kind::RecordDamaged => self.log.damage(TOPIC, strike.victim % PARTITIONS),
        }
    }

    pub(super) fn end(&mut self, strike: &Strike) {
        match strike.kind {
            Kind::SupervisorKilled | Kind::SupervisorStopped | Kind::SupervisorUpgraded => {
                if strike.kind == Kind::SupervisorUpgraded {
                    self.server.upgrade();
                }
                let member = self.member(strike);
                member.kill();
                member.start();
            }
            Kind::SupervisorFrozen => {
                if let Some(process) = self.member(strike).process() {
                    process.thaw();
                }
            }
            Kind::HostClockStepped => self.member(strike).host.step(-Self::step_us(strike)),
            Kind::ToBrokerCut => self.member(strike).routes.broker.set_cut(Way::ToBroker, false),
            Kind::FromBrokerCut => self.member(strike).routes.broker.set_cut(Way::ToClient, false),
            Kind::BrokerRestarted | Kind::BrokerReplaced => self.broker.set_accepting(true),
            Kind::BrokerFrozen => self.broker.set_frozen(false),
            Kind::Repetitions => self.broker.set_repetition(0.0),
            Kind::SlowBroker | Kind::TopicsOvertake => {
                self.broker.set_delay(Way::ToClient, Delay::default());
                self.broker.set_topics_overtake(false);
            }
            Kind::RobotAway => self.robot(strike).set_off(false),
            Kind::ToStoreCut => self.member(strike).way.cut_requests(false),
            Kind::FromStoreCut => self.member(strike).way.cut_answers(false),
            Kind::AnswersLost => self.member(strike).way.lose_answers(false),
            Kind::StoreSlow => self.server.set_work(None),
            Kind::StoreAway => self.server.set_up(true),
            Kind::StoreFull => self.server.set_full(false),
            Kind::StoreFailover => {
                if let Some((before, snapshot)) = self.failover.take() {
                    let mut observations = locked(&self.observations);
                    observations.record.drain(&self.robots, &mut self.server.data());
                    self.server.fail_over_to(before);
                    observations.record.lose_since(snapshot);
                    self.receivers.lose_commits();
                }
            }
            Kind::OperatorHolds => self.act(strike, "RELEASE"),
            Kind::ReceiverSlow | Kind::ReceiverFails | Kind::ReceiverSilent | Kind::ReceiverCuts => {
                self.receivers.set(strike.victim, Manner::Works);
            }
            Kind::ToLogCut => self.member(strike).routes.log.set_cut(Way::ToBroker, false),
            Kind::FromLogCut => self.member(strike).routes.log.set_cut(Way::ToClient, false),
            Kind::LogDown => self.log.set_down(false),
            Kind::LogFrozen => self.log.set_frozen(false),
            Kind::PartitionAway => self.log.set_away(TOPIC, strike.victim % PARTITIONS, false),
            Kind::RecordsRepeated => self.bridge.set_repetition(0.0),
            Kind::RecordsLate => self.bridge.set_delay(Duration::ZERO),
            Kind::BrokerLinkReset
            | Kind::SubscriptionsForgotten
            | Kind::RobotCut
            | Kind::RobotRestarted
            | Kind::Hostile
            | Kind::RecordsDeleted
            | Kind::RecordDamaged
            | Kind::StoreClockStepped => {}
        }
    }

    /// A client publishes damaged copies of robots' messages as another robot.
    fn hostile(&self, strike: &Strike) {
        let heard: Vec<(String, Vec<u8>)> = self.observations().heard.iter().cloned().collect();
        let (broker, mut random) = (self.broker.clone(), ChaCha8Rng::seed_from_u64(strike.measure));
        vibrissa_host::task::spawn(async move {
            let id = format!("hostile-{}", random.random::<u32>());
            let Ok(mut client) = Client::connect(&broker, ClientOptions::new(id)).await else { return };
            for (topic, mut payload) in heard {
                let levels: Vec<&str> = topic.rsplitn(3, '/').collect();
                let [kind, _, fleet] = levels[..] else { continue };
                for _ in 0..random.random_range(0..4) {
                    let at = random.random_range(0..payload.len().max(1));
                    if let Some(byte) = payload.get_mut(at) {
                        *byte = *b"0123456789-.eE\"{}[]:,nutl\0\xff".choose(&mut random).unwrap_or(&b' ');
                    }
                }
                client.publish(
                    &format!("{fleet}/h{:02}/{kind}", random.random_range(0..5)),
                    payload,
                    QoS::AtLeastOnce,
                    false,
                );
            }
            sleep(Duration::from_millis(50)).await;
        });
    }

    /// An operator's action on a whisker.
    fn act(&self, strike: &Strike, kind: &str) {
        let (fleet, robot) = self.robot(strike).with(|robot| (robot.fleet().to_string(), robot.name().to_string()));
        let now_us = self.server.clock().now_us();
        let action = NewAction {
            fleet: Some(fleet),
            robot: Some(robot),
            array: Some("left".to_owned()),
            whisker: Some((strike.measure % 2) as i64),
            compensation_id: None,
            alarm_id: None,
            kind: kind.to_owned(),
            parameters: "{}".to_owned(),
            reason: None,
            actor: "operator".to_owned(),
            role: "OPERATOR".to_owned(),
            request_id: String::new(),
            idempotency_key: None,
            asked_us: now_us,
            expires_us: now_us + 30_000_000,
        };
        self.server.data().request_action(&action);
    }
}
