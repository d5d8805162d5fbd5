//! Plants faults in the database: triggers that refuse rows.

use sqlx::{AssertSqlSafe, ConnectOptions};

use crate::stage::Stage;

/// An administrator's connection to the database.
pub(crate) enum Admin {
    Sqlite(sqlx::SqliteConnection),
    Postgres(sqlx::PgConnection),
}

macro_rules! with {
    ($admin:expr, |$link:ident| $body:expr) => {
        match $admin {
            Admin::Sqlite($link) => $body,
            Admin::Postgres($link) => $body,
        }
    };
}

impl Admin {
    pub(crate) async fn of(stage: &Stage) -> Self {
        match &stage.server {
            Some(server) => Self::Postgres(server.connect().connect().await.unwrap()),
            None => {
                let options = sqlx::sqlite::SqliteConnectOptions::new().filename(stage.folder.path().join("v.sqlite3"));
                Self::Sqlite(options.busy_timeout(std::time::Duration::from_secs(20)).connect().await.unwrap())
            }
        }
    }

    /// Refuses new and changed rows (named `n`) of a table that satisfy a condition.
    pub(crate) async fn refuse(&mut self, table: &str, condition: &str) {
        let condition = condition.replace("n.", "NEW.");
        let sql = match self {
            Self::Sqlite(_) => ["INSERT", "UPDATE"]
                .map(|action| {
                    format!(
                        "CREATE TRIGGER planted_{action} BEFORE {action} ON {table} WHEN {condition} \
                         BEGIN SELECT RAISE(ABORT, 'planted'); END;"
                    )
                })
                .join(" "),
            Self::Postgres(_) => format!(
                "CREATE FUNCTION planted() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN IF {condition} THEN \
                 RAISE EXCEPTION 'planted' USING ERRCODE = '23514'; END IF; RETURN NEW; END $$; \
                 CREATE TRIGGER planted BEFORE INSERT OR UPDATE ON {table} FOR EACH ROW EXECUTE FUNCTION planted();"
            ),
        };
        with!(self, |link| sqlx::raw_sql(AssertSqlSafe(sql)).execute(link).await.map(drop)).unwrap();
    }

    /// Removes the triggers.
    pub(crate) async fn relent(&mut self, table: &str) {
        let sql = match self {
            Self::Sqlite(_) => "DROP TRIGGER planted_INSERT; DROP TRIGGER planted_UPDATE;".to_owned(),
            Self::Postgres(_) => format!("DROP TRIGGER planted ON {table}; DROP FUNCTION planted();"),
        };
        with!(self, |link| sqlx::raw_sql(AssertSqlSafe(sql)).execute(link).await.map(drop)).unwrap();
    }

    /// Integers in the first column of all rows.
    pub(crate) async fn numbers(&mut self, sql: &str) -> Vec<i64> {
        let sql = AssertSqlSafe(sql.to_owned());
        with!(self, |link| sqlx::query_scalar(sql).fetch_all(link).await).unwrap()
    }
}
