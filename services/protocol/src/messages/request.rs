use serde::{Deserialize, Serialize};

use super::{Checked, TouchTest};
use crate::{BootId, Refusal, RequestKind, check};

/// `request`: the supervisor asks a robot to send a message again, or to do a touch test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(
    feature = "documents",
    derive(schemars::JsonSchema),
    schemars(transform = crate::schema::touch_test_where_due)
)]
pub struct Request {
    /// Boot id of the supervisor.
    pub boot_id: BootId,
    /// Sequence number, from 0 in each boot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub seq: u64,
    /// The requested message, or `TOUCH_TEST`.
    pub request: RequestKind,
    /// The test of a `TOUCH_TEST`; absent otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[serde(deserialize_with = "crate::shape::object_if_any")]
    pub touch_test: Option<TouchTest>,
}

impl Checked for Request {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        let problem = match (self.request, &self.touch_test) {
            (RequestKind::TouchTest, Some(test)) => {
                return test.check().map_err(|refusal| refusal.in_field("touch_test"));
            }
            (RequestKind::TouchTest, None) => "missing, but TOUCH_TEST needs one",
            (RequestKind::Factsheet | RequestKind::Status, Some(_)) => "only TOUCH_TEST has one",
            (RequestKind::Factsheet | RequestKind::Status, None) => return Ok(()),
        };
        Err(Refusal::Malformed { path: "touch_test".to_owned(), problem: problem.to_owned() })
    }
}
