//! The state of the connections, and the texts for people.

use super::*;
use crate::mqtt::address::BrokerAddress;
use crate::mqtt::problem::Cause;

fn node() -> Node {
    BrokerAddress::new("h", 1).node()
}

#[test]
fn pauses_double_from_a_quarter_of_a_second_to_five() {
    let mut backoff = Backoff::new();
    for due_ms in [250, 500, 1000, 2000, 4000, 5000, 5000] {
        let pause = backoff.pause();
        let due = Duration::from_millis(due_ms);
        assert!((due / 2..=due).contains(&pause), "{pause:?} of {due:?}");
    }
    backoff.reset();
    assert!(backoff.pause() <= Backoff::START);
}

#[test]
fn pauses_differ() {
    let pauses: std::collections::BTreeSet<_> = (0..50).map(|_| Backoff::new().pause()).collect();
    assert!(pauses.len() > 10, "{pauses:?}");
}

#[test]
fn a_link_stands_when_both_connections_do() {
    let link = BrokerLink::default();
    assert_eq!(link.problem().as_deref(), Some("not connected to the MQTT broker yet"));
    link.connected(Side::Receiving, &node());
    assert!(link.problem().is_some());
    link.connected(Side::Publishing, &node());
    assert_eq!(link.problem(), None);
    let problem = Problem::new(&BrokerAddress::new("h", 1), Cause::Refused);
    link.broken(Side::Publishing, &problem);
    assert_eq!(link.problem(), Some(problem.to_string()));
    link.connected(Side::Publishing, &node());
    assert_eq!(link.problem(), None);
}

#[test]
fn an_outage_names_the_problem_of_each_node_and_then_the_node_in_use() {
    let link = BrokerLink::default();
    let problem = |host, cause| Problem::new(&BrokerAddress::new(host, 1), cause);
    let (first, second) = (problem("h", Cause::Refused), problem("i", Cause::NoAnswer));
    for _ in 0..3 {
        link.broken(Side::Receiving, &first);
        link.broken(Side::Receiving, &second);
    }
    link.connected(Side::Publishing, &node());
    assert_eq!(link.problems(), [second.to_string(), first.to_string()]);
    let publishing = Some("h:1".to_owned());
    assert_eq!(link.nodes(), NodesInUse { receiving: None, publishing });
}

#[test]
fn deafness_lasts_from_the_first_loss_to_the_next_proof_and_is_the_receivers_alone() {
    let link = BrokerLink::default();
    assert!(link.deafness().is_some(), "deaf before the first proof");
    link.connected(Side::Publishing, &node());
    assert!(link.deafness().is_some());
    link.connected(Side::Receiving, &node());
    assert_eq!(link.deafness(), None);
    let problem = |cause| Problem::new(&BrokerAddress::new("h", 1), cause);
    link.broken(Side::Publishing, &problem(Cause::Refused));
    assert_eq!(link.deafness(), None);
    link.broken(Side::Receiving, &problem(Cause::Silent));
    let (first, _) = link.deafness().unwrap();
    vibrissa_host::task::block_for(Duration::from_millis(2));
    link.broken(Side::Receiving, &problem(Cause::Refused));
    let (later, why) = link.deafness().unwrap();
    assert!(later > first && why == problem(Cause::Refused).to_string(), "{why}");
}

#[test]
fn a_connection_that_is_closed_alone_is_told_apart_from_a_broker_that_ends() {
    let closed = Problem::new(&BrokerAddress::new("h", 1), Cause::Closed);
    let refused = Problem::new(&BrokerAddress::new("h", 1), Cause::Refused);
    let sides = [Side::Receiving, Side::Publishing];
    for (side, other) in [(sides[0], sides[1]), (sides[1], sides[0])] {
        let link = BrokerLink::default();
        assert!(!link.connected(side, &node()) && !link.connected(other, &node()));
        link.broken(side, &closed);
        assert!(link.connected(side, &node()), "the other connection stayed up");
        assert!(!link.connected(side, &node()), "reported only once");
        // A failed attempt in between changes nothing.
        link.broken(side, &closed);
        link.broken(side, &refused);
        assert!(link.connected(side, &node()));
        // The broker stops.
        link.broken(side, &closed);
        link.broken(other, &closed);
        assert!(!link.connected(side, &node()) && !link.connected(other, &node()));
        // An end with a stated reason does not count.
        link.broken(side, &refused);
        assert!(!link.connected(side, &node()));
    }
}

fn refusal(topic: &str) -> Problem {
    let (topic, why) = (topic.to_owned(), "NotAuthorized".to_owned());
    Problem::new(&BrokerAddress::new("h", 1), Cause::Publication { topic, why })
}

/// The supervisor's own state was accepted every five seconds, which cleared the refusal of a setpoint.
#[test]
fn regress_a_refusal_lasts_until_its_own_topic_is_accepted() {
    let link = BrokerLink::default();
    link.connected(Side::Receiving, &node());
    link.connected(Side::Publishing, &node());
    let (first, second) = ("whisker/v1/f/r1/setpoint", "whisker/v1/f/r2/setpoint");
    link.refused(first, &refusal(first));
    for _ in 0..3 {
        link.connected(Side::Publishing, &node());
        link.accepted("whisker/v1/f/supervisor/state");
        link.accepted(second);
        assert!(link.problem().is_some_and(|problem| problem.contains(first)), "{:?}", link.problems());
    }
    link.refused(second, &refusal(second));
    assert!(link.problems().len() == 1 && link.problems()[0].ends_with("the same on 1 more topics"));
    link.accepted(first);
    link.accepted(second);
    assert_eq!(link.problem(), None);
}

#[test]
fn a_limit_that_ordinary_messages_exceed_is_a_problem_of_the_node_in_use() {
    let link = BrokerLink::default();
    link.connected(Side::Receiving, &node());
    link.connected(Side::Publishing, &node());
    let limit = |is_too_low| Some(LowLimit { what: "packets of 100 bytes".to_owned(), is_too_low });
    link.limited(&node(), limit(false));
    assert_eq!(link.problem(), None);
    link.limited(&node(), limit(true));
    assert_eq!(link.problem().as_deref(), Some("MQTT broker h:1: packets of 100 bytes"));
    link.limited(&node(), None);
    assert_eq!(link.problem(), None);
}

#[test]
fn takeovers_are_logged_once_a_minute_with_their_number() {
    let (mut link, now) = (Link::default(), Instant::now());
    assert_eq!(link.takeovers_to_log(now), Some(1));
    for _ in 0..200 {
        assert_eq!(link.takeovers_to_log(now + TAKEOVERS_LOGGED_EVERY / 2), None);
    }
    assert_eq!(link.takeovers_to_log(now + TAKEOVERS_LOGGED_EVERY), Some(201));
}
