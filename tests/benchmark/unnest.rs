//! Measures the ceiling of PostgreSQL with whole statements: a plain table without an index, filled with UNNEST.

use std::time::{Duration, Instant};

use sqlx::{ConnectOptions, Connection, Executor};
use vibrissa_tests::postgres::Postgres;

const ROWS: usize = 1000;
const TABLE: &str = "CREATE TABLE plain (robot TEXT NOT NULL, whisker INTEGER NOT NULL, seq BIGINT NOT NULL, \
                     t_us BIGINT NOT NULL, ratio DOUBLE PRECISION, deflection_mm DOUBLE PRECISION, strain DOUBLE PRECISION, \
                     pressure_mpa DOUBLE PRECISION, temperature_c DOUBLE PRECISION)";
const INSERT: &str = "INSERT INTO plain SELECT * FROM UNNEST($1::TEXT[], $2::INTEGER[], $3::BIGINT[], $4::BIGINT[], \
                      $5::DOUBLE PRECISION[], $6::DOUBLE PRECISION[], $7::DOUBLE PRECISION[], $8::DOUBLE PRECISION[], \
                      $9::DOUBLE PRECISION[])";

/// Rows per second during this time; each statement inserts 1000 rows in a transaction of its own.
pub async fn rows_per_s(server: &Postgres, time: Duration) -> anyhow::Result<f64> {
    let mut connection = server.connect().connect().await?;
    connection.execute("DROP TABLE IF EXISTS plain").await?;
    connection.execute(TABLE).await?;
    let robots: Vec<String> = (0..ROWS).map(|row| format!("r{:06}", row % 50)).collect();
    let whiskers: Vec<i32> = (0..ROWS as i32).map(|row| row / 50 % 8).collect();
    let numbers: Vec<f64> = (0..ROWS).map(|row| 2.4 + (row % 10) as f64 * 0.01).collect();
    let begun = Instant::now();
    let mut rows = 0;
    while begun.elapsed() < time {
        let seqs: Vec<i64> = (rows..rows + ROWS as i64).collect();
        let times_us: Vec<i64> = seqs.iter().map(|seq| 1_795_248_000_000_000 + 100 * seq).collect();
        let mut insert = sqlx::query(INSERT).bind(&robots).bind(&whiskers).bind(&seqs).bind(&times_us);
        for _ in 0..5 {
            insert = insert.bind(&numbers);
        }
        insert.execute(&mut connection).await?;
        rows += ROWS as i64;
    }
    let rate = rows as f64 / begun.elapsed().as_secs_f64();
    connection.execute("DROP TABLE plain").await?;
    connection.close().await?;
    Ok(rate)
}
