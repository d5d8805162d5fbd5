//! Why the database fails, with what to do: one text for each cause of SQLite, PostgreSQL and sqlx.

use vibrissa_protocol::plain;

/// Short description of an error, without the database's own text, which may show statements and values.
pub(crate) fn outline(problem: &sqlx::Error) -> String {
    if let sqlx::Error::Database(error) = problem {
        let code = error.code().unwrap_or_default();
        let is_sqlite = error.try_downcast_ref::<sqlx::sqlite::SqliteError>().is_some();
        let known = if is_sqlite { of_sqlite(&code) } else { of_sqlstate(&code) };
        return match (known, &*code) {
            (Some(known), _) => format!("{known} (code {code})"),
            (None, "") => "refused".to_owned(),
            (None, _) => format!("refused with code {code}"),
        };
    }
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the others need no words of their own")]
    match problem {
        sqlx::Error::Io(problem) => {
            format!("no connection ({}): check that the server runs, and its address", problem.kind())
        }
        sqlx::Error::Tls(problem) => format!("no encrypted connection: {}", of_tls(&problem.to_string())),
        sqlx::Error::PoolTimedOut => "no free connection in time: the database is slow or not reachable".to_owned(),
        sqlx::Error::PoolClosed | sqlx::Error::WorkerCrashed => {
            "all connections are closed: the service is stopping".to_owned()
        }
        sqlx::Error::Protocol(_) => {
            "the server does not answer as PostgreSQL: check the port of database.url, and proxies in between"
                .to_owned()
        }
        sqlx::Error::Configuration(_) | sqlx::Error::InvalidArgument(_) => {
            "an option of the address cannot be used: correct database.url".to_owned()
        }
        sqlx::Error::ColumnDecode { .. }
        | sqlx::Error::ColumnNotFound(_)
        | sqlx::Error::Decode(_)
        | sqlx::Error::TypeNotFound { .. } => {
            "this version cannot read a stored value: was the database changed by hand, or by another version?"
                .to_owned()
        }
        // sqlx may add variants.
        _ => "no usable answer".to_owned(),
    }
}

/// Description of an error for the log: the cause, and the database's own message in quotes.
pub(crate) fn for_log(problem: &sqlx::Error) -> String {
    let cause = outline(problem);
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the others have no text of their own")]
    let said = match problem {
        sqlx::Error::Database(detail) => detail.message().to_owned(),
        sqlx::Error::Io(problem) => plain::io(problem),
        sqlx::Error::Configuration(detail) => plain::text(&detail.to_string()),
        sqlx::Error::Decode(detail) => of_value(&detail.to_string()),
        sqlx::Error::ColumnDecode { index, source } => {
            format!("column {}: {}", index.trim_matches('"'), of_value(&source.to_string()))
        }
        sqlx::Error::ColumnNotFound(detail) | sqlx::Error::Protocol(detail) | sqlx::Error::InvalidArgument(detail) => {
            detail.clone()
        }
        _ => String::new(),
    };
    let said = said.split(char::is_control).collect::<Vec<_>>().join(" ");
    if said.is_empty() { cause } else { format!("{cause}; it says {said:?}") }
}

/// Description of a failed migration for the log.
pub(crate) fn of_migration(problem: &sqlx::migrate::MigrateError) -> String {
    use sqlx::migrate::MigrateError;
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the others cannot happen here")]
    match problem {
        MigrateError::Execute(source) => for_log(source),
        MigrateError::ExecuteMigration(source, version) => format!("migration {version}: {}", for_log(source)),
        MigrateError::VersionMismatch(version) => format!(
            "migration {version} is not the one that was applied: this program was built from changed files; use a release"
        ),
        MigrateError::Dirty(version) => format!(
            "migration {version} was interrupted: restore the back-up from before the upgrade, or ask for help with it"
        ),
        _ => "the program's own migrations cannot be used: use a release".to_owned(),
    }
}

/// Why a stored value cannot be read, without the types of Rust.
fn of_value(text: &str) -> String {
    if text.starts_with("mismatched types") {
        let stored = text.rsplit('`').nth(1).unwrap_or_default();
        return format!("it is of the type {stored}");
    }
    if text.starts_with("unexpected null") { "it is empty".to_owned() } else { plain::data(text) }
}

/// Why there is no encrypted connection.
fn of_tls(text: &str) -> String {
    let text = plain::text(text);
    if text.contains(": ") { text } else { format!("{text}: check sslmode and sslrootcert in database.url") }
}

/// The cause of an SQLSTATE.
fn of_sqlstate(code: &str) -> Option<&'static str> {
    Some(match code {
        "28P01" => "password authentication failed: correct the user or database.password_file",
        "28000" => "the server does not admit this user: correct the user, or let pg_hba.conf and the role admit it",
        "3D000" => "the database does not exist: create it, or correct database.url",
        "3F000" => {
            "no schema of the user's search_path exists: create it, or set search_path to public (ALTER ROLE ... SET search_path)"
        }
        "42P01" | "42703" | "42883" => {
            "a part of the tables is missing: was the database restored in part, or changed by hand?"
        }
        "42501" => "this user lacks a right: grant it (docs/postgresql.md lists the rights)",
        "53100" => "the server's disk is full: free space there",
        "53200" => "the server has no memory: give it more",
        "53300" => "too many connections: raise max_connections, or stop other clients",
        "53400" => "a limit of the server's configuration is reached: raise it",
        "57014" => {
            "the server cancelled the statement: it took longer than statement_timeout, or somebody cancelled it"
        }
        "57P01" | "57P02" | "57P03" | "57P05" => "the server is starting or stopping",
        "25006" => {
            "the server accepts no writes, because it is a standby or read-only: let database.url name the primary"
        }
        "26000" | "42P05" => "prepared statements fail: if PgBouncer is in between, set its pool_mode to session",
        "40001" | "40P01" => "another transaction was in the way",
        "55P03" => "a table is locked by another client: end its transaction",
        "58030" | "58P01" => "the server cannot read or write its files: check its disk",
        "XX001" | "XX002" => "the server finds its data damaged: restore a back-up",
        _ => match code.get(..2)? {
            "08" => "the connection broke",
            "22" => "a value cannot be stored",
            "23" | "44" | "P0" => "a rule of the table refuses the row",
            "53" => "the server lacks a resource: look at its log",
            "54" => "a value or the statement is too large",
            "57" => "the server ended the statement: look at its log",
            "58" => "the server's system has a fault: look at its log",
            "XX" => "the server has an internal fault: look at its log",
            _ => return None,
        },
    })
}

/// The cause of a result code of SQLite: sqlite.org/rescode.html.
fn of_sqlite(code: &str) -> Option<&'static str> {
    let code: u32 = code.parse().ok()?;
    Some(match (code, code & 0xff) {
        (_, 3 | 23) => "this user may not use the file: give it the right to read and write it",
        (_, 5 | 6) => "another program has locked the file: end it, or wait until it is done",
        (_, 7) => "this host has no memory: give it more",
        (_, 8) => {
            "the file cannot be written: give this user the right to write it and its folder, or mount the disk for writing"
        }
        (_, 10) => "the disk fails at reading or writing the file: check it, and its free space",
        (_, 11 | 26) => {
            "the file is damaged: stop the service, keep the file, and restore a back-up (docs/operations.md, Restore)"
        }
        (_, 13) => "the disk is full: free space, or shorten database.retention",
        (_, 14) => "the file cannot be opened: check its path, and that this user may read and write its folder",
        (_, 17) => "the tables were changed by another program: start again",
        (_, 18) => "a value or the statement is too large",
        (_, 19) => "a rule of the table refuses the row",
        (_, 20 | 25) => "a value cannot be stored",
        (_, 21) => "the library was used wrongly: report it as a bug",
        (_, 1) => "a part of the tables is missing: was the file changed by hand, or by another program?",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_each_code_of_a_cause_that_people_can_end_has_a_remedy() {
        for code in ["3", "5", "7", "8", "10", "11", "13", "14", "26", "1", "778", "1032", "3850"] {
            let text = of_sqlite(code).unwrap_or_else(|| panic!("SQLite {code}"));
            assert!(text.contains(": "), "SQLite {code}: {text}");
        }
        for code in ["28P01", "3D000", "3F000", "42501", "42P01", "53100", "53200", "53300", "55P03", "58030", "XX001"]
        {
            let text = of_sqlstate(code).unwrap_or_else(|| panic!("SQLSTATE {code}"));
            assert!(text.contains(": "), "SQLSTATE {code}: {text}");
        }
        assert_eq!(
            (of_sqlite("x"), of_sqlite("999"), of_sqlstate("0"), of_sqlstate("99999")),
            (None, None, None, None)
        );
    }

    #[test]
    fn regress_errors_of_the_library_lose_its_words() {
        let refused = std::io::Error::from_raw_os_error(111);
        let certificate = "invalid peer certificate: Other(OtherError(CaUsedAsEndEntity))";
        for problem in [
            sqlx::Error::Io(refused),
            sqlx::Error::PoolTimedOut,
            sqlx::Error::Tls(certificate.into()),
            sqlx::Error::Protocol("expecting ParseComplete".to_owned()),
            sqlx::Error::ColumnNotFound("x".to_owned()),
        ] {
            for text in [outline(&problem), for_log(&problem)] {
                assert!(text.contains(": ") && !text.contains("os error") && !text.contains("Other"), "{text}");
            }
            assert!(!outline(&problem).contains("ParseComplete"));
        }
    }

    #[test]
    fn regress_a_value_of_another_type_is_told_without_types_of_rust() {
        const MISMATCH: &str =
            "mismatched types; Rust type `i64` (as SQL type `INTEGER`) is not compatible with SQL type `TEXT`";
        let null = sqlx::error::UnexpectedNullError;
        for (source, part) in [
            (MISMATCH.into(), "column of_it: it is of the type TEXT"),
            (Box::new(null) as sqlx::error::BoxDynError, "column of_it: it is empty"),
        ] {
            let text = for_log(&sqlx::Error::ColumnDecode { index: "\"of_it\"".to_owned(), source });
            assert!(text.contains(part) && !text.contains("Rust") && !text.contains("Option"), "{text}");
        }
        let text = for_log(&sqlx::Error::Decode(serde_json::from_str::<i64>("x").unwrap_err().into()));
        assert!(!text.contains("expected value"), "{text}");
    }

    #[tokio::test]
    async fn regress_a_statement_that_fails_does_not_show_its_text() {
        use sqlx::Connection as _;
        let mut database = sqlx::SqliteConnection::connect("sqlite::memory:").await.unwrap();
        let problem = sqlx::query("SELECT secret FROM nowhere").execute(&mut database).await.unwrap_err();
        let (short, long) = (outline(&problem), for_log(&problem));
        assert!(short.starts_with("a part of the tables is missing:") && !short.contains("nowhere"), "{short}");
        assert!(long.contains("nowhere") && !long.contains("SELECT") && !long.contains("error returned"), "{long}");
    }
}
