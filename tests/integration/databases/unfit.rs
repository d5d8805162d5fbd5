//! PostgreSQL databases that the program refuses, each in words that name the remedy.

use sqlx::{ConnectOptions, Executor};
use vibrissa_store::{DatabaseAddress, Store, StoreError};
use vibrissa_tests::postgres::{DATABASE, Postgres};

async fn prepared(url: &str) -> Result<(), StoreError> {
    let address: DatabaseAddress = url.parse().unwrap();
    Store::open(&address, "unfit").await?.prepare().await
}

#[tokio::test]
async fn regress_a_database_in_another_encoding_or_without_its_tables_is_refused() {
    let server = Postgres::start().await;
    let mut link = server.connect().connect().await.unwrap();
    for encoding in ["LATIN1", "SQL_ASCII"] {
        let create = format!("CREATE DATABASE other ENCODING '{encoding}' LOCALE 'C' TEMPLATE template0");
        link.execute(sqlx::AssertSqlSafe(create)).await.unwrap();
        let url = format!("{}other", Postgres::url(server.port()).strip_suffix(DATABASE).unwrap());
        let told = prepared(&url).await.unwrap_err();
        assert!(!told.is_passing());
        let told = told.to_string();
        assert!(told.contains(encoding) && told.contains("createdb --encoding=UTF8"), "{told}");
        link.execute("DROP DATABASE other WITH (FORCE)").await.unwrap();
    }
    let url = Postgres::url(server.port());
    assert!(prepared(&url).await.is_ok());
    link.execute("DROP TABLE setpoints CASCADE").await.unwrap();
    let told = prepared(&url).await.unwrap_err().to_string();
    assert!(told.contains("setpoints") && told.contains("pg_restore"), "{told}");
}
