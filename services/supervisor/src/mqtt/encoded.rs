//! A publication of the engine as MQTT sends it.

use rumqttc::{PublishOptions, PublishProperties, QoS};
use tokio::time::Instant;
use vibrissa_protocol::{Name, QualityOfService};

use crate::outbox::{Publication, Stopwatch};

/// An encoded publication.
#[derive(Debug)]
pub(super) struct Encoded {
    pub(super) topic: String,
    pub(super) payload: Vec<u8>,
    pub(super) qos: QualityOfService,
    /// Whether it is a receipt: a statement of commits.
    pub(super) is_receipt: bool,
    pub(super) is_retained: bool,
    /// Deadline for sending.
    pub(super) until: Option<Instant>,
    pub(super) stopwatch: Option<Stopwatch>,
}

impl Encoded {
    /// Encodes a publication to a robot of the fleet.
    pub(super) fn of(publication: Publication, fleet: &Name) -> Self {
        let kind = publication.message.topic();
        Self {
            topic: kind.of(fleet, &publication.robot).to_string(),
            payload: publication.message.encoded(),
            qos: kind.quality_of_service(),
            is_receipt: publication.states_a_commit(),
            is_retained: publication.is_retained(),
            until: publication.until,
            stopwatch: publication.stopwatch,
        }
    }

    /// MQTT options at `now`; `None` if it has expired. The remaining time becomes the MQTT message expiry, except
    /// for a retained message: robots that connect later need it. `retains` is whether the broker retains messages.
    pub(super) fn options(&self, now: Instant, retains: bool) -> Option<PublishOptions> {
        let options = PublishOptions::new(match self.qos {
            QualityOfService::AtMostOnce => QoS::AtMostOnce,
            QualityOfService::AtLeastOnce => QoS::AtLeastOnce,
        });
        let options = options.retain(self.is_retained && retains);
        let Some(until) = self.until else { return Some(options) };
        let left = until.checked_duration_since(now).filter(|left| !left.is_zero())?;
        if self.is_retained {
            return Some(options);
        }
        // The expiry is in whole seconds. It is rounded up, because a broker may take 0 for no expiry.
        let left_s = left.as_secs_f64().ceil() as u32;
        let properties = PublishProperties { message_expiry_interval: Some(left_s), ..PublishProperties::default() };
        Some(options.properties(properties))
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use vibrissa_protocol::{BootId, Request, RequestKind, RobotTopic, encode};

    use super::*;
    use crate::outbox::ToRobot;

    fn encoded(message: ToRobot, until: Option<Instant>) -> Encoded {
        let [fleet, robot] = ["f", "r"].map(|name| Name::new(name).unwrap());
        Encoded::of(Publication { until, ..Publication::new(robot, message) }, &fleet)
    }

    fn request() -> Request {
        Request { boot_id: BootId::new("s").unwrap(), seq: 1, request: RequestKind::Factsheet, touch_test: None }
    }

    #[test]
    fn a_publication_has_topic_and_payload_of_the_contract() {
        let encoded = encoded(ToRobot::Request(request()), None);
        assert_eq!((encoded.topic.as_str(), encoded.is_retained), ("whisker/v1/f/r/request", false));
        assert_eq!((encoded.payload, encoded.is_receipt), (encode(&request()), false));
    }

    #[test]
    fn a_publication_keeps_what_is_left_of_its_time_and_does_not_go_out_after_it() {
        let now = Instant::now();
        let goes_out = |left_ms: u64| {
            let until = now + Duration::from_millis(left_ms);
            encoded(ToRobot::Request(request()), Some(until)).options(now, true).map(|options| format!("{options:?}"))
        };
        for (left_ms, expiry_s) in [(1, 1), (999, 1), (1001, 2), (9_500, 10)] {
            let options = goes_out(left_ms).expect("not expired yet");
            assert!(options.contains(&format!("message_expiry_interval: Some({expiry_s})")), "{left_ms}: {options}");
        }
        assert_eq!(goes_out(0), None);
        let late = encoded(ToRobot::Request(request()), Some(now));
        assert!(late.options(now + Duration::from_secs(1), true).is_none());
        assert!(encoded(ToRobot::Request(request()), None).options(now, true).is_some());
    }

    #[test]
    fn a_retained_publication_goes_out_only_before_its_deadline_and_does_not_expire_in_the_broker() {
        let now = Instant::now();
        let publication = encoded(ToRobot::Cleared(RobotTopic::Estimate), Some(now + Duration::from_secs(5)));
        let options = format!("{:?}", publication.options(now, true).expect("not too late yet"));
        assert!(options.contains("retain: true"), "{options}");
        assert!(!options.contains("Some(5)"), "{options}");
        assert!(publication.options(now + Duration::from_secs(6), true).is_none());
        let options = format!("{:?}", publication.options(now, false));
        assert!(options.contains("retain: false"), "{options}");
    }
}
