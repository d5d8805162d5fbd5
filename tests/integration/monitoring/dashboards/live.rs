//! Runs every query of every dashboard on a real Prometheus and a real PostgreSQL, while a fleet is supervised.

use std::io::Write as _;
use std::process::{Command, Stdio};

use serde_json::Value;
use sqlx::postgres::PgConnection;
use sqlx::{AssertSqlSafe, Executor, Row};
use vibrissa_tests::web::try_get;

use super::expand::Chosen;
use super::shape::drill_downs;
use super::stage::Stage;
use super::{ALL, Dashboard, list, targets, text};
use crate::alerts::named_alerts;

/// Factor on the number of contacts for the test of query plans.
const HISTORY: u32 = 10;

#[tokio::test(flavor = "multi_thread")]
async fn every_query_shows_something_of_a_fleet_that_is_supervised() {
    let stage = Stage::new().await;
    let choices = stage.choices().await;
    let (_, metrics) = try_get(stage.http, "/metrics").await.unwrap();
    lint_metrics(&metrics);
    let mut problems = Vec::new();
    for dashboard in ALL.iter() {
        problems.extend(promql_problems(&stage, dashboard, &choices[0].of_pattern(dashboard.takes_fleets())).await);
    }
    let mut link = stage.grafana().await;
    let queries: Vec<Query> = ALL.iter().flat_map(queries).collect();
    assert!(queries.len() > 40, "queries in SQL: {}", queries.len());
    for query in &queries {
        problems.extend(sql_problem(&mut link, query, &choices).await);
    }
    assert!(problems.is_empty(), "\n{}", problems.join("\n"));
    stage.rest();
    make_history(&stage).await;
    for query in &queries {
        plan_uses_indexes(&mut link, query, &choices[0]).await;
    }
    alerts_can_be_asked(&mut link).await;
    reads_and_no_more(&mut link).await;
}

/// Checks names, units and help of metrics with promtool.
fn lint_metrics(metrics: &str) {
    let mut promtool = Command::new("promtool")
        .args(["check", "metrics"])
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("promtool must be installed for this test");
    promtool.stdin.take().unwrap().write_all(metrics.as_bytes()).unwrap();
    let ended = promtool.wait_with_output().unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
}

async fn promql_problems(stage: &Stage, dashboard: &Dashboard, chosen: &Chosen) -> Vec<String> {
    let mut problems = Vec::new();
    for (panel, target) in dashboard.promql() {
        let place = format!("{}: {}: {}", dashboard.title(), text(&panel["title"]), text(&target["refId"]));
        match show(stage, chosen, target).await {
            Ok(series) if series.iter().all(|one| values(one) == 0) => {
                problems.push(format!("{place}: no series for {}", chosen.promql(text(&target["expr"]))));
            }
            Ok(series) => {
                let named = labels(text(&target["legendFormat"]));
                let unnamed = series.iter().find(|one| named.iter().any(|&label| one["metric"][label].is_null()));
                problems.extend(unnamed.map(|one| format!("{place}: {named:?} in {}", one["metric"])));
            }
            Err(problem) => problems.push(format!("{place}: {problem}")),
        }
    }
    for variable in dashboard.variables().filter(|one| one["query"]["query"].is_string()) {
        let query = chosen.promql(text(&variable["query"]["query"]));
        let (series, label) = query.strip_prefix("label_values(").and_then(|rest| rest.rsplit_once(", ")).unwrap();
        let label = label.trim_end_matches(')');
        let data = stage.prometheus.ask(&format!("label/{label}/values"), &[("match[]", series)]).await.unwrap();
        if list(&data).count() == 0 {
            problems.push(format!("{}: no values for variable {}", dashboard.title(), variable["name"]));
        }
    }
    problems
}

/// Series of a query, as the panel requests it.
async fn show(stage: &Stage, chosen: &Chosen, target: &Value) -> Result<Vec<Value>, String> {
    let expression = chosen.promql(text(&target["expr"]));
    let seconds = |us: i64| (us / 1_000_000).to_string();
    let data = if target["instant"] == true {
        stage.prometheus.ask("query", &[("query", &expression), ("time", &seconds(chosen.to_us))]).await?
    } else {
        let span = [("start", seconds(chosen.from_us)), ("end", seconds(chosen.to_us)), ("step", "1".to_owned())];
        let mut parameters = vec![("query", expression.as_str())];
        parameters.extend(span.iter().map(|(name, value)| (*name, value.as_str())));
        stage.prometheus.ask("query_range", &parameters).await?
    };
    Ok(list(&data["result"]).cloned().collect())
}

/// Number of values in a series.
fn values(series: &Value) -> usize {
    let samples = list(&series["values"]).chain(series.get("value"));
    samples.filter(|sample| text(&sample[1]).parse::<f64>().is_ok_and(f64::is_finite)).count()
}

/// Labels that a legend names.
fn labels(legend: &str) -> Vec<&str> {
    legend.split("{{").skip(1).map(|rest| rest.split("}}").next().unwrap()).collect()
}

/// A query in SQL and its required columns.
struct Query {
    place: String,
    /// Whether several fleets can be chosen.
    takes_fleets: bool,
    sql: String,
    columns: Vec<String>,
}

/// All queries in SQL: of panels, annotations and variables.
fn queries(dashboard: &Dashboard) -> Vec<Query> {
    let place = |what: &str, name: &Value| format!("{}: {what}{}", dashboard.title(), text(name));
    let takes_fleets = dashboard.takes_fleets();
    let of_panels = dashboard.panels().flat_map(targets).filter(|(_, target)| target["rawSql"].is_string());
    let panels = of_panels.map(|(panel, target)| Query {
        takes_fleets,
        place: place("", &panel["title"]) + ": " + text(&target["refId"]),
        sql: text(&target["rawSql"]).to_owned(),
        columns: columns(dashboard, panel, target),
    });
    let annotations = list(&dashboard.json["annotations"]["list"]).map(|one| Query {
        takes_fleets,
        place: place("annotation ", &one["name"]),
        sql: text(&one["target"]["rawSql"]).to_owned(),
        columns: ["time", "text", "tags"].map(str::to_owned).to_vec(),
    });
    let of_database = dashboard.variables().filter(|one| one["type"] == "query" && one["query"].is_string());
    let variables = of_database.map(|one| Query {
        takes_fleets,
        place: place("variable ", &one["name"]),
        sql: text(&one["query"]).to_owned(),
        columns: Vec::new(),
    });
    panels.chain(annotations).chain(variables).collect()
}

/// The columns that a panel uses.
fn columns(dashboard: &Dashboard, panel: &Value, target: &Value) -> Vec<String> {
    let is_alone = targets(panel).count() == 1;
    let overrides = list(&panel["fieldConfig"]["overrides"]).map(|one| text(&one["matcher"]["options"]));
    let links = drill_downs(dashboard).filter(|(of, _)| of["id"] == panel["id"]).map(|(_, link)| link);
    let fields = links.flat_map(|link| link.split("${__data.fields.").skip(1));
    let mut columns: Vec<&str> = fields.map(|rest| rest.split('}').next().unwrap()).collect();
    columns.extend(overrides.filter(|_| is_alone));
    columns.extend(panel["options"]["xField"].as_str());
    columns.extend((target["format"] == "time_series" || panel["type"] == "state-timeline").then_some("time"));
    columns.into_iter().map(str::to_owned).collect()
}

/// The problem of a query, if any: it fails, a column is missing, or no whisker has rows.
async fn sql_problem(link: &mut PgConnection, query: &Query, choices: &[Chosen]) -> Option<String> {
    for chosen in choices {
        let sql = format!(
            "SELECT row_to_json(q)::text FROM (\n{}\n) q",
            chosen.of_pattern(query.takes_fleets).sql(&query.sql)
        );
        let rows = match sqlx::query(AssertSqlSafe(sql)).fetch_all(&mut *link).await {
            Ok(rows) => rows,
            Err(problem) => return Some(format!("{}: {problem}:\n{}", query.place, query.sql)),
        };
        let rows: Vec<Value> = rows.iter().map(|row| serde_json::from_str(row.get(0)).unwrap()).collect();
        let Some(first) = rows.first() else { continue };
        if let Some(column) = query.columns.iter().find(|column| first.get(column.as_str()).is_none()) {
            return Some(format!("{}: no column {column} in {first}", query.place));
        }
        // A row with a time but no value shows nothing.
        let has_value =
            |row: &Value| row.as_object().unwrap().iter().any(|(name, value)| name != "time" && !value.is_null());
        if rows.iter().any(has_value) {
            return None;
        }
    }
    Some(format!("{}: no rows:\n{}", query.place, query.sql))
}

/// Copies the contacts to earlier days.
async fn make_history(stage: &Stage) {
    let mut owner = stage.owner().await;
    let columns = "ratio, deflection_mm, strain, pressure_mpa, temperature_c, used, residual, length_mm, length_sd_mm";
    let copy = format!(
        "INSERT INTO contacts (whisker_id, boot, seq, position, t_us, received_us, {columns}) \
         SELECT whisker_id, boot, seq, position, t_us - day * 86400000000, received_us - day * 86400000000, {columns} \
         FROM contacts, generate_series(1, {HISTORY}) day"
    );
    owner.execute(AssertSqlSafe(copy)).await.unwrap();
    owner.execute("ANALYZE").await.unwrap();
}

async fn plan_uses_indexes(link: &mut PgConnection, query: &Query, chosen: &Chosen) {
    let explain = format!("EXPLAIN {}", chosen.of_pattern(query.takes_fleets).sql(&query.sql));
    let plan = sqlx::query(AssertSqlSafe(explain)).fetch_all(link).await.unwrap();
    let plan: Vec<String> = plan.iter().map(|row| row.get(0)).collect();
    // In this database only two days have partitions; all other contacts are in the default partition.
    let scans = plan.iter().any(|line| line.contains("Seq Scan on contacts_default"));
    assert!(!scans, "{} scans all contacts:\n{}", query.place, plan.join("\n"));
}

/// Runs the queries of Grafana's alerts with Grafana's role.
async fn alerts_can_be_asked(link: &mut PgConnection) {
    for (alert, rule) in named_alerts() {
        let query = text(&rule["data"][0]["model"]["rawSql"]).to_owned();
        assert!(query.contains("SELECT"), "{alert}");
        link.execute(AssertSqlSafe(query)).await.unwrap_or_else(|problem| panic!("{alert}: {problem}"));
    }
}

/// Checks that the role cannot write, even after it has switched off its read-only default.
async fn reads_and_no_more(link: &mut PgConnection) {
    let own = link.fetch_one("SHOW default_transaction_read_only").await.unwrap().get::<String, _>(0);
    assert_eq!(own, "on");
    link.execute("SET default_transaction_read_only = off").await.unwrap();
    for forbidden in [
        "SELECT * FROM api_tokens",
        "SELECT count(*) FROM api_tokens",
        "SELECT actor FROM actions",
        "SELECT changed_by FROM policies",
        "SELECT measurements FROM calibrations",
        "SELECT state FROM robots",
        "SELECT state FROM whiskers",
        "INSERT INTO alarms (whisker_id, raised_us, kind) SELECT whisker_id, 0, 'STALE' FROM whiskers",
        "UPDATE whiskers SET held = TRUE",
        "DELETE FROM contacts",
        "TRUNCATE contacts",
        "CREATE TABLE mine (n BIGINT)",
        "CREATE ROLE other",
    ] {
        let problem = link.execute(forbidden).await.err().unwrap_or_else(|| panic!("{forbidden}: was allowed"));
        let code = problem.as_database_error().and_then(|problem| problem.code().map(|code| code.into_owned()));
        assert_eq!(code.as_deref(), Some("42501"), "{forbidden}: {problem}");
    }
}
