//! HTTP requests that must succeed.

use std::collections::BTreeMap;
use std::net::SocketAddr;

use serde_json::Value;
use vibrissa_tests::web::try_get;

/// Status and body of an answer.
pub(crate) async fn get(address: SocketAddr, path: &str) -> (u16, String) {
    try_get(address, path).await.unwrap()
}

/// JSON of an answer with status 200.
pub(crate) async fn json(address: SocketAddr, path: &str) -> Value {
    let (status, body) = get(address, path).await;
    assert_eq!(status, 200, "{path}: {body}");
    serde_json::from_str(&body).unwrap()
}

/// Values of all metrics by name with labels, such as `vibrissa_database_up`.
#[derive(Debug, Clone)]
pub(crate) struct Metrics(BTreeMap<String, f64>);

impl Metrics {
    pub(crate) async fn read(address: SocketAddr) -> Self {
        let (status, body) = get(address, "/metrics").await;
        assert_eq!(status, 200, "{body}");
        let sample = |line: &str| {
            let (name, value) = line.rsplit_once(' ').unwrap_or_else(|| panic!("no sample: {line}"));
            (name.to_owned(), value.parse().unwrap_or_else(|_| panic!("no number: {line}")))
        };
        let lines = body.lines().filter(|line| !line.starts_with('#') && !line.is_empty());
        Self(lines.map(sample).collect())
    }

    /// Value of a metric; zero if it does not exist.
    pub(crate) fn get(&self, name: &str) -> f64 {
        self.0.get(name).copied().unwrap_or_default()
    }

    /// Counts of refused messages by reason.
    pub(crate) fn refused(&self) -> BTreeMap<String, f64> {
        let before = "vibrissa_messages_refused_total{fleet=\"f\",reason=\"";
        let reason = |name: &str| Some(name.strip_prefix(before)?.strip_suffix("\"}")?.to_owned());
        let some = self.0.iter().filter(|&(_, &value)| value > 0.0);
        some.filter_map(|(name, &value)| Some((reason(name)?, value))).collect()
    }

    /// Names of all series with their labels.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }
}
