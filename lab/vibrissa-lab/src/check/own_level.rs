//! The topics that the robot uses, from the record of the relay.

use vibrissa_protocol::{Name, Rule, Topic};

use super::bench::Bench;
use vibrissa_supervisor::mqtt::ClientRecord;

/// Prefix of a filter of a shared subscription, before the name of its group.
const SHARED: &str = "$share/";

/// The topics of a robot.
struct Own {
    level: String,
    to_all: String,
}

impl Own {
    fn new(fleet: &Name, robot: &Name) -> Self {
        let connection = vibrissa_protocol::RobotTopic::Connection.of(fleet, robot).to_string();
        let level = connection.trim_end_matches("connection").to_owned();
        Self { level, to_all: Topic::SupervisorRequest { fleet: fleet.clone() }.to_string() }
    }

    /// Whether a connection is the robot's.
    fn is_of(&self, client: &ClientRecord) -> bool {
        client.will.iter().chain(&client.published).any(|topic| topic.starts_with(&self.level))
    }

    fn may_publish(&self, topic: &str) -> bool {
        topic.len() > self.level.len() && topic.starts_with(&self.level)
    }

    fn may_subscribe(&self, filter: &str) -> bool {
        let shared = filter.strip_prefix(SHARED).and_then(|rest| rest.split_once('/')).map(|(_, filter)| filter);
        let filter = shared.unwrap_or(filter);
        self.may_publish(filter) || filter == self.to_all
    }

    /// Forbidden uses of topics by a connection, as text.
    fn foreign(&self, client: &ClientRecord) -> Vec<String> {
        let published = client.published.iter().filter(|topic| !self.may_publish(topic));
        let subscribed = client.subscribed.iter().filter(|filter| !self.may_subscribe(filter));
        let will = client.will.iter().filter(|topic| !self.may_publish(topic));
        let published = published.map(|topic| format!("it publishes on {topic}"));
        let subscribed = subscribed.map(|filter| format!("it subscribes to {filter}"));
        let will = will.map(|topic| format!("its last will is for {topic}"));
        published.chain(subscribed).chain(will).collect()
    }
}

impl Bench {
    /// Judges the topics of the robot.
    pub(super) fn own_level(&mut self) {
        let rules = [Rule::OwnLevel];
        let Some(record) = &self.options.relay else {
            self.skip(
                &rules,
                "requires the broker of the check, or --relay with --broker: the robot's packets must pass it",
            );
            return;
        };
        let own = Own::new(&self.options.fleet, &self.options.robot);
        let clients = record.clients();
        let its: Vec<&ClientRecord> = clients.iter().filter(|client| own.is_of(client)).collect();
        let foreign: Vec<String> = its.iter().flat_map(|client| own.foreign(client)).collect();
        let trouble = its.iter().find_map(|client| client.trouble.clone());
        if let Some(first) = foreign.first() {
            let others = foreign.iter().collect::<std::collections::BTreeSet<_>>().len() - 1;
            let more = if others > 0 { format!(", and {others} more") } else { String::new() };
            self.fail(rules[0], format!("{first}{more}"));
        } else if let Some(trouble) = trouble {
            self.skip(&rules, &format!("not all packets of the robot could be read: {trouble}"));
        } else if its.is_empty() {
            let why = clients.iter().find_map(|client| client.trouble.clone());
            let why = why.map_or(String::new(), |trouble| format!("; of another client: {trouble}"));
            self.skip(&rules, &format!("no connection of the robot passed the relay{why}"));
        } else {
            let all = |of: fn(&ClientRecord) -> &std::collections::BTreeSet<String>| {
                its.iter().flat_map(|client| of(client)).collect::<std::collections::BTreeSet<_>>().len()
            };
            let (published, subscribed) = (all(|client| &client.published), all(|client| &client.subscribed));
            self.pass(
                rules[0],
                format!("it publishes on {published} topics and subscribes to {subscribed} filters, all its own"),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_may_use_its_own_level_and_requests_to_its_fleet() {
        let own = Own::new(&Name::new("f").unwrap(), &Name::robot("r").unwrap());
        for topic in ["whisker/v1/f/r/status", "whisker/v1/f/r/own/more"] {
            assert!(own.may_publish(topic) && own.may_subscribe(topic), "{topic}");
        }
        for filter in ["whisker/v1/f/supervisor/request", "whisker/v1/f/r/#", "$share/g/whisker/v1/f/r/+"] {
            assert!(own.may_subscribe(filter), "{filter}");
        }
        for topic in ["whisker/v1/f/r2/status", "whisker/v1/f/r/", "whisker/v1/g/r/status", "log", ""] {
            assert!(!own.may_publish(topic), "{topic}");
        }
        for filter in ["#", "whisker/v1/f/+/receipt", "whisker/v1/f/supervisor/+", "whisker/v1/g/supervisor/request"] {
            assert!(!own.may_subscribe(filter), "{filter}");
        }
        assert!(!own.may_publish("whisker/v1/f/supervisor/request"));
    }
}
