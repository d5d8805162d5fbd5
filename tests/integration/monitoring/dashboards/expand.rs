//! Expands variables and macros in queries as Grafana does.

use std::collections::BTreeMap;

/// Chosen values of variables, and the time range.
#[derive(Debug, Clone, Default)]
pub(super) struct Chosen {
    /// Chosen values by variable.
    pub(super) variables: BTreeMap<&'static str, Vec<String>>,
    /// Begin of the time range, microseconds since 1970 UTC.
    pub(super) from_us: i64,
    /// End of the time range, microseconds since 1970 UTC.
    pub(super) to_us: i64,
}

impl Chosen {
    /// The same with a pattern instead of the fleet, if the dashboard takes several.
    pub(super) fn of_pattern(&self, takes_several: bool) -> Self {
        let mut chosen = self.clone();
        if let Some(fleets) = chosen.variables.get_mut("fleet").filter(|_| takes_several) {
            fleets.iter_mut().for_each(|fleet| fleet.replace_range(1.., ".*"));
        }
        chosen
    }

    /// Expands SQL as the PostgreSQL data source does, with intervals of one second.
    ///
    /// # Panics
    /// The query has a variable or macro that this function does not know.
    pub(super) fn sql(&self, query: &str) -> String {
        let mut query = query.to_owned();
        for (name, values) in &self.variables {
            let quoted: Vec<String> = values.iter().map(|value| format!("'{}'", value.replace('\'', "''"))).collect();
            query = query.replace(&format!("${{{name}:sqlstring}}"), &quoted.join(","));
        }
        let nanoseconds = |us: i64| (1000 * us).to_string();
        let query = query
            .replace("$__unixEpochNanoFrom()", &nanoseconds(self.from_us))
            .replace("$__unixEpochNanoTo()", &nanoseconds(self.to_us))
            .replace("$__interval_ms", "1000");
        assert!(!query.contains('$'), "not fully expanded: {query}");
        query
    }

    /// Expands PromQL as the Prometheus data source does with a scrape interval of one second: `$__rate_interval` is
    /// four seconds.
    ///
    /// # Panics
    /// The query has a variable or macro that this function does not know.
    pub(super) fn promql(&self, query: &str) -> String {
        let mut query = query.replace("$__rate_interval", "4s");
        query = query.replace("$__range", &format!("{}s", (self.to_us - self.from_us) / 1_000_000));
        for (name, values) in &self.variables {
            query = query.replace(&format!("${name}\""), &format!("{}\"", values.join("|")));
            query = query.replace(&format!("${{{name}:pipe}}"), &values.join("|"));
        }
        assert!(!query.contains('$'), "not fully expanded: {query}");
        query
    }
}

#[test]
fn values_cannot_leave_their_quotes() {
    let variables =
        BTreeMap::from([("fleet", vec!["a".to_owned(), "o'b; DROP".to_owned()]), ("job", vec![".+".to_owned()])]);
    let chosen = Chosen { variables, from_us: 1_000_000, to_us: 61_000_000 };
    let query =
        "fleet IN (${fleet:sqlstring}) AND us BETWEEN $__unixEpochNanoFrom() / 1000 AND $__unixEpochNanoTo() / 1000";
    let expected = "fleet IN ('a','o''b; DROP') AND us BETWEEN 1000000000 / 1000 AND 61000000000 / 1000";
    assert_eq!(chosen.sql(query), expected);
    let query = r#"increase(x{job=~"$job"}[$__range]) > rate(x{fleet=~"${fleet:pipe}"}[$__rate_interval])"#;
    let expected = r#"increase(x{job=~".+"}[60s]) > rate(x{fleet=~"a|o'b; DROP"}[4s])"#;
    assert_eq!(chosen.promql(query), expected);
    assert_eq!(chosen.of_pattern(true).variables["fleet"], ["a.*", "o.*"]);
}
