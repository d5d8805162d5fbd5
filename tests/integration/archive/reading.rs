//! Reads an archive with DuckDB.

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use vibrissa_tests::oracle::ledger::{Content, Ledger, Recorded};
use vibrissa_tests::python::environment;

/// Runs a Python program of this folder and returns what it prints.
pub(crate) fn python(program: &str, arguments: &[&str]) -> String {
    let python = environment("requirements-archive.txt", env!("CARGO_TARGET_TMPDIR")).join("python");
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/integration/archive")).join(program);
    let output = Command::new(python).arg(path).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// All rows below a folder, with their types.
pub(crate) struct Archive {
    pub(crate) types: Value,
    pub(crate) files: usize,
    rows: Vec<Value>,
}

impl Archive {
    pub(crate) fn read(folder: &Path) -> Self {
        let mut read: Value = serde_json::from_str(&python("read.py", &[folder.to_str().unwrap()])).unwrap();
        let Value::Array(rows) = read["rows"].take() else { panic!("no rows") };
        assert_eq!(read["wrong_days"], 0, "each file must have the contacts of the day in its name");
        Self { types: read["types"].take(), files: read["files"].as_u64().unwrap() as usize, rows }
    }

    pub(crate) fn contacts(&self) -> usize {
        self.rows.len()
    }

    /// Adds the rows to the record of what robots made.
    pub(crate) fn compare(&self, ledger: &mut Ledger) {
        for row in &self.rows {
            ledger.recorded(Recorded {
                robot: row["robot"].as_str().unwrap().to_owned(),
                boot_id: row["boot_id"].as_str().unwrap().to_owned(),
                seq: row["seq"].as_u64().unwrap(),
                position: row["position"].as_u64().unwrap() as usize,
                content: Content {
                    array: row["array"].as_str().unwrap().to_owned(),
                    whisker: row["whisker"].as_i64().unwrap(),
                    t_us: row["at"].as_i64().unwrap(),
                    values: ["ratio", "deflection_mm", "strain", "pressure_mpa", "temperature_c"]
                        .map(|name| row[name].as_f64().unwrap()),
                },
            });
        }
    }
}
