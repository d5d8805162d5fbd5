use std::path::PathBuf;

use crate::{DatabaseAddress, Store, StoreError};

/// A change of a file's bytes.
type Change = fn(&mut Vec<u8>);

/// A folder that is removed at the end.
pub(crate) struct Folder(PathBuf);

impl Folder {
    pub(crate) fn new() -> Self {
        let name = vibrissa_host::random::hex();
        let folder = std::env::temp_dir().join(format!("vibrissa-sqlite-{name}"));
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    pub(crate) fn file(&self) -> PathBuf {
        self.0.join("v.sqlite3")
    }

    async fn open(&self) -> Result<(), StoreError> {
        let store = Store::open(&DatabaseAddress::Sqlite(self.file()), "test").await?;
        let done = async {
            store.check().await?;
            store.prepare().await
        };
        let done = done.await;
        store.close().await;
        done
    }

    /// A database with rows.
    async fn filled() -> Self {
        let folder = Self::new();
        let store = Store::open(&DatabaseAddress::Sqlite(folder.file()), "test").await.unwrap();
        store.prepare().await.unwrap();
        let crate::database::Either::Sqlite(pool) = &store.pool else { panic!("SQLite") };
        const ROWS: &str = "WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 2000) \
             INSERT INTO events (fleet, kind, audience, recorded_us, version, data) SELECT 'f', 'TRIM', 'PEOPLE', i, 2, '{}' FROM n";
        sqlx::query(ROWS).execute(pool).await.unwrap();
        sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)").execute(pool).await.unwrap();
        store.close().await;
        folder
    }

    fn change(&self, change: impl FnOnce(&mut Vec<u8>)) {
        let mut bytes = std::fs::read(self.file()).unwrap();
        change(&mut bytes);
        std::fs::write(self.file(), bytes).unwrap();
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn refusal_of(done: Result<(), StoreError>) -> String {
    let problem = done.expect_err("it must be refused");
    assert!(!problem.is_passing(), "{problem}");
    problem.to_string()
}

#[tokio::test]
async fn regress_an_installation_does_not_go_on_with_an_empty_database() {
    let folder = Folder::filled().await;
    assert!(folder.open().await.is_ok());
    let aside = folder.0.join("aside");
    std::fs::rename(folder.file(), &aside).unwrap();
    let missing = refusal_of(folder.open().await);
    assert!(missing.contains("restore the newest back-up") && missing.contains("v.sqlite3.lock"), "{missing}");
    std::fs::write(folder.file(), "").unwrap();
    assert_eq!(refusal_of(folder.open().await), missing, "an empty file");
    // A database without tables.
    let options = sqlx::sqlite::SqliteConnectOptions::new().filename(folder.file());
    let mut link = sqlx::ConnectOptions::connect(&options).await.unwrap();
    sqlx::query("PRAGMA user_version = 3").execute(&mut link).await.unwrap();
    sqlx::Connection::close(link).await.unwrap();
    assert_eq!(refusal_of(folder.open().await), missing, "no tables");
    // The remedies: the old file, or the mark's removal.
    std::fs::rename(&aside, folder.file()).unwrap();
    assert!(folder.open().await.is_ok());
    std::fs::remove_file(folder.file()).unwrap();
    std::fs::remove_file(folder.0.join("v.sqlite3.lock")).unwrap();
    assert!(folder.open().await.is_ok(), "a new installation");
}

#[tokio::test]
async fn regress_a_damaged_file_is_refused_with_its_remedy() {
    let folder = Folder::filled().await;
    let whole = std::fs::read(folder.file()).unwrap();
    let changes: [(&str, Change); 4] = [
        ("200 flipped bits", |bytes| {
            let (mut at, length) = (12_345_u64, bytes.len() as u64);
            for _ in 0..200 {
                at = at.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let place = 4096 + (at >> 16) % (length - 4096);
                bytes[place as usize] ^= 1 << (at >> 60 & 7);
            }
        }),
        ("a header", |bytes| bytes[..16].fill(0x55)),
        ("a page size", |bytes| bytes[16..18].copy_from_slice(&[0, 3])),
        ("a shortened file", |bytes| bytes.truncate(bytes.len() / 2)),
    ];
    for (what, change) in changes {
        folder.change(change);
        let refusal = refusal_of(folder.open().await);
        assert!(refusal.contains("is damaged") && refusal.contains("restore the newest back-up"), "{what}: {refusal}");
        std::fs::write(folder.file(), &whole).unwrap();
        assert!(folder.open().await.is_ok(), "{what}");
    }
}

#[tokio::test]
async fn regress_a_command_that_works_for_long_lets_a_supervisor_start() {
    let folder = Folder::new();
    let command = Store::open_for_command(&DatabaseAddress::Sqlite(folder.file())).await.unwrap();
    folder.open().await.unwrap();
    command.close().await;
}
