//! Estimates of lengths: whether a robot that divides distances by a length uses the newest one that it was told.
//!
//! The helper touches one whisker at one place. If the robot divides, contact ratio × length stays the same whatever
//! length it is told. A robot that knows its lengths by itself sends the same ratio.

use std::time::Duration;

use vibrissa_protocol::{
    BootId, Contact, Estimate, Factsheet, Message, Name, RobotTopic, Rule, Timestamp, WhiskerCondition, WhiskerEstimate,
};

use super::action::{Action, Spot};
use super::assisted::Told;
use super::bench::Bench;
use super::divisor::{Divisor, First, Touches};
use super::listener::Listener;
use super::report::seconds;
use super::touched::Touched;
use vibrissa_edge::clock::wall_clock;
use vibrissa_supervisor::mqtt::{Connection, TestClient};

/// Touches after each estimate.
const TOUCHES: usize = 6;
/// Half of the interval of a length, relative.
const INTERVAL: f64 = 0.01;
const RULES: [Rule; 2] = [Rule::EstimateLength, Rule::EstimateOrder];

impl Bench {
    /// Tests whether the robot follows estimates.
    pub(super) async fn estimates(&mut self, connection: &Connection, progress: Told<'_>) -> anyhow::Result<()> {
        let Some(factsheet) = self.heard.factsheet.clone() else { return Ok(()) };
        let trial = self.trial.as_ref().map(super::Trial::spot);
        let Some(touched) = Touched::choose(&factsheet, trial) else {
            self.exempt(
                &RULES,
                "the factsheet states contact ratios for none of its whiskers: it divides by no length",
            );
            return Ok(());
        };
        let Some(boot) = self.heard.boot.clone() else { return Ok(()) };
        let mut reader = Reader::open(self, connection).await;
        self.please(progress, Action::TouchPlace(touched.spot.clone()), self.timings().help);
        let found = self.divisor(&factsheet, &touched, &boot, &mut reader).await;
        reader.close().await;
        self.please(progress, Action::Rest, self.timings().help);
        let divisor = found?;
        let (length, order) = (divisor.length(), divisor.order());
        for (rule, judgement) in [(Rule::EstimateLength, length), (Rule::EstimateOrder, order)] {
            self.heard.findings.take(rule, judgement);
        }
        Ok(())
    }

    async fn divisor(
        &mut self,
        factsheet: &Factsheet,
        touched: &Touched,
        boot: &BootId,
        reader: &mut Reader,
    ) -> anyhow::Result<Divisor> {
        let (one_mm, two_mm) = touched.lengths_mm();
        let help = self.timings().help;
        let before = self.touches(touched, boot, help).await?;
        let mut divisor = Divisor { first: First::Unknown(before), lengths_mm: (one_mm, two_mm), ..Divisor::default() };
        if before == Touches::None {
            divisor.limit = Some(seconds(help));
            return Ok(divisor);
        }
        let limit = self.timings().contacts;
        self.wrong_length = Some(touched.clone());
        let older = self.tell_lengths(factsheet, touched, Some(one_mm)).await?;
        if self.heard.was_born(boot) && reader.knows_that_none_was_retained().await {
            divisor.first = First::WithoutEstimate(before);
        }
        divisor.one = self.touches(touched, boot, limit).await?;
        let newest = self.tell_lengths(factsheet, touched, Some(two_mm)).await?;
        divisor.two = self.touches(touched, boot, limit).await?;
        if divisor.follows() {
            // The first length again, in estimates that are not newer.
            let mut orders = vec![(newest.epoch, newest.version), (newest.epoch, newest.version - 1)];
            if newest.epoch > 0 {
                orders.push((newest.epoch - 1, newest.version + 1_000_000));
            }
            for (epoch, version) in orders {
                let (_, seq, _) = self.next_estimate();
                self.tell_estimate(&Estimate { seq, epoch, version, ..older.clone() }).await?;
            }
            divisor.stale = self.touches(touched, boot, limit).await?;
        }
        self.withdraw_lengths().await?;
        self.heard.findings.note(format!(
            "the robot was told lengths of {one_mm:.1} and {two_mm:.1} mm for {}, and then none: the next supervisor tells \
             it the present ones",
            touched.spot
        ));
        Ok(divisor)
    }

    /// Withdraws the estimates with a wrong length, if the check has sent any.
    pub(super) async fn withdraw_lengths(&mut self) -> anyhow::Result<()> {
        let (Some(touched), Some(factsheet)) = (self.wrong_length.clone(), self.heard.factsheet.clone()) else {
            return Ok(());
        };
        // A robot that overlooks the withdrawal keeps the length of its factsheet.
        self.tell_lengths(&factsheet, &touched, Some(touched.length_mm)).await?;
        self.tell_lengths(&factsheet, &touched, None).await?;
        self.wrong_length = None;
        Ok(())
    }

    /// Tells the robot a length of the whisker, and the factsheet's of the others; or that there are no estimates.
    async fn tell_lengths(
        &mut self,
        factsheet: &Factsheet,
        touched: &Touched,
        length_mm: Option<f64>,
    ) -> anyhow::Result<Estimate> {
        let mut whiskers = Vec::new();
        if let Some(length_mm) = length_mm {
            for array in &factsheet.arrays {
                for one in &array.whiskers {
                    let is_touched = touched.spot.array == array.array && touched.spot.whisker == one.whisker;
                    let length_mm = if is_touched { length_mm } else { one.length_mm };
                    whiskers.push(estimate_of(&array.array, one.whisker, length_mm, one.pressure_mpa));
                }
            }
        }
        let estimate = self.estimate(whiskers);
        self.tell_estimate(&estimate).await?;
        Ok(estimate)
    }

    async fn tell_estimate(&mut self, estimate: &Estimate) -> anyhow::Result<()> {
        self.heard.note_sent_lengths();
        self.say(RobotTopic::Estimate, vibrissa_protocol::encode(estimate), None).await
    }

    /// The next touches of the whisker, made later than the messages that were sent to the robot.
    async fn touches(&mut self, touched: &Touched, boot: &BootId, limit: Duration) -> anyhow::Result<Touches> {
        let (mark, since_us) = (self.mark(), self.heard.robot_clock_us() + self.timings().grace.as_micros() as u64);
        let made = |heard: &Listener| contacts(heard, mark, boot, &touched.spot, since_us);
        self.until(limit, |heard| (made(heard).len() >= TOUCHES).then_some(())).await?;
        Ok(Touches::of(&made(&self.heard)))
    }
}

/// Reads the robot's estimates, to know whether the broker retains one of the last supervisor.
struct Reader {
    client: Option<TestClient>,
    retains: bool,
    is_none_retained: bool,
    answer: Duration,
}

impl Reader {
    async fn open(bench: &Bench, connection: &Connection) -> Self {
        let (fleet, robot) = (&bench.options.fleet, &bench.options.robot);
        let topic = RobotTopic::Estimate.of(fleet, robot).to_string();
        // The access list of a broker may forbid this topic to the check.
        let mut client = TestClient::open(connection, &[topic]).await.ok();
        let is_none_retained = match &mut client {
            Some(client) => tokio::time::timeout(bench.timings().retained, client.next()).await.is_err(),
            None => false,
        };
        Self { client, retains: bench.heard.retains, is_none_retained, answer: bench.timings().answer }
    }

    /// Whether there was none. The first estimate of the check shows that the reader receives estimates.
    async fn knows_that_none_was_retained(&mut self) -> bool {
        let Some(client) = self.client.as_mut().filter(|_| self.is_none_retained) else { return !self.retains };
        !self.retains || matches!(tokio::time::timeout(self.answer, client.next()).await, Ok(Ok(_)))
    }

    async fn close(self) {
        if let Some(client) = self.client {
            client.close().await;
        }
    }
}

impl Bench {
    fn estimate(&mut self, whiskers: Vec<WhiskerEstimate>) -> Estimate {
        let (boot_id, seq, version) = self.next_estimate();
        Estimate { boot_id, seq, epoch: self.epoch, version, timestamp: Timestamp(wall_clock().0), whiskers }
    }
}

fn estimate_of(array: &Name, whisker: u16, length_mm: f64, pressure_mpa: f64) -> WhiskerEstimate {
    WhiskerEstimate {
        array: array.clone(),
        whisker,
        length_mm,
        length_low_mm: (1.0 - INTERVAL) * length_mm,
        length_high_mm: (1.0 + INTERVAL) * length_mm,
        condition: WhiskerCondition::Healthy,
        pressure_mpa,
        gain: Vec::new(),
        reading_gain: None,
        response: Vec::new(),
    }
}

/// Contacts of a whisker in a boot that were made after a time by the robot's clock, without those of touch tests.
fn contacts(heard: &Listener, mark: usize, boot: &BootId, spot: &Spot, since_us: u64) -> Vec<Contact> {
    let mut found: Vec<Contact> = Vec::new();
    for entry in &heard.log[mark..] {
        if let Message::Contacts(message) = &entry.message
            && message.boot_id == *boot
        {
            let fits = |one: &&Contact| {
                one.array == spot.array && one.whisker == spot.whisker && one.t_us > since_us && one.test_id.is_none()
            };
            // A message that is sent again counts once.
            let new =
                message.contacts.iter().filter(fits).filter(|one| found.iter().all(|other| other.t_us != one.t_us));
            let new: Vec<Contact> = new.cloned().collect();
            found.extend(new);
        }
    }
    found
}
