//! The settings of docs/archive.md, which write a topic of contacts to a table of Apache Iceberg.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::{Field, Row};
use serde_json::{Value, json};
use vibrissa_protocol::{RobotTopic, Topic, receive};
use vibrissa_tests::kafka::{Kafka, START, record};
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::until_within;

const TOPIC: &str = "vibrissa.messages";
const CONTROL: &str = "control-iceberg";
const PARTITIONS: u32 = 2;
/// First messages of contacts that must be in the table, and most that are sent.
const ENOUGH: usize = 60;
const MOST: usize = 20_000;
/// Folder of Kafka Connect and the connector, if they are installed.
fn connectors() -> Option<PathBuf> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("connectors");
    let output = Command::new(script).arg("--if-installed").output().unwrap();
    if !output.status.success() {
        eprintln!("skipped: {}", String::from_utf8_lossy(&output.stderr).trim());
        return None;
    }
    Some(PathBuf::from(String::from_utf8(output.stdout).unwrap().trim()))
}

/// The documented settings, with this folder in the place of a database and of S3, and commits each second.
fn settings(folder: &Path) -> String {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/archive.md")).unwrap();
    let mut blocks = text.split("```properties\n").skip(1).map(|block| block.split("```").next().unwrap());
    let documented = blocks.find(|block| block.contains("IcebergSinkConnector")).unwrap();
    let mut own = BTreeMap::from([
        ("iceberg.catalog.uri", format!("jdbc:sqlite:{}", folder.join("catalog.sqlite3").display())),
        ("iceberg.catalog.warehouse", format!("file://{}", folder.join("warehouse").display())),
        ("iceberg.catalog.io-impl", "org.apache.iceberg.hadoop.HadoopFileIO".to_owned()),
        ("iceberg.control.commit.interval-ms", "1000".to_owned()),
    ]);
    let mut lines = Vec::new();
    for line in documented.lines() {
        let (key, _) = line.split_once(" = ").unwrap();
        lines.push(own.remove(key).map_or_else(|| line.to_owned(), |value| format!("{key} = {value}")));
    }
    assert!(own.is_empty(), "the documents do not set {own:?}");
    // Readers of this test know no zstd, the connector's default.
    lines.push("iceberg.tables.auto-create-props.write.parquet.compression-codec = snappy".to_owned());
    lines.join("\n")
}

fn worker(home: &Path, folder: &Path, kafka: &Kafka) -> Launch {
    let write = |name: &str, text: &str| {
        fs::write(folder.join(name), text).unwrap();
        folder.join(name).display().to_string()
    };
    let of_worker = write(
        "worker.properties",
        &format!(
            "bootstrap.servers={}\nplugin.path={}\nlisteners=http://127.0.0.1:{}\noffset.storage.file.filename={}\n\
             key.converter=org.apache.kafka.connect.storage.StringConverter\n\
             value.converter=org.apache.kafka.connect.json.JsonConverter\noffset.flush.interval.ms=1000\n",
            kafka.addresses().join(","),
            home.join("plugins").display(),
            free_port(),
            folder.join("offsets").display(),
        ),
    );
    let of_connector = write("iceberg.properties", &settings(folder));
    let mut arguments = ["-Xmx512M", "-XX:+UseSerialGC", "-XX:TieredStopAtLevel=1", "-cp"].map(str::to_owned).to_vec();
    arguments.push(home.join("connect/*").display().to_string());
    arguments.push("org.apache.kafka.connect.cli.ConnectStandalone".to_owned());
    arguments.extend([of_worker, of_connector]);
    Launch { program: PathBuf::from("java"), arguments, environment: Vec::new(), log: folder.join("log") }
}

fn field<'a>(row: &'a Row, name: &str) -> &'a Field {
    row.get_column_iter().find_map(|(column, field)| (column == name).then_some(field)).unwrap_or(&Field::Null)
}

/// Strain and ratio of each contact of a message.
type Values = Vec<(f64, Option<f64>)>;

/// Messages of contacts in the table's files, by boot and number, and how often each one is there.
fn stored(folder: &Path) -> BTreeMap<(String, i64), (u32, Values)> {
    let mut all = BTreeMap::new();
    let Ok(files) = fs::read_dir(folder.join("warehouse/whiskers/messages/data")) else { return all };
    for path in
        files.map(|file| file.unwrap().path()).filter(|path| path.extension().is_some_and(|end| end == "parquet"))
    {
        // The connector may be writing it.
        let Ok(reader) = SerializedFileReader::new(File::open(path).unwrap()) else { continue };
        for row in reader.get_row_iter(None).unwrap().map(Result::unwrap) {
            let (Field::Str(boot), Field::Long(seq)) = (field(&row, "boot_id"), field(&row, "seq")) else {
                panic!("{row}")
            };
            let Field::ListInternal(contacts) = field(&row, "contacts") else { continue };
            let values = contacts.elements().iter().map(|contact| {
                let Field::Group(contact) = contact else { panic!("{contact}") };
                let Field::Double(strain) = field(contact, "strain") else { panic!("{contact}") };
                let Field::Double(ratio) = field(contact, "ratio") else { return (*strain, None) };
                (*strain, Some(*ratio))
            });
            all.entry((boot.clone(), *seq)).or_insert((0, values.collect())).0 += 1;
        }
    }
    all
}

/// A message of two contacts, the second at a place that the robot does not know, and now and then a status.
fn messages(seq: i64) -> (Values, Vec<(RobotTopic, Value)>) {
    let boot_id = "boot-1";
    let values = vec![(0.001 * seq as f64, Some(0.7)), (0.002 * seq as f64, None)];
    let contact = |whisker: i64, (strain, ratio): (f64, Option<f64>)| {
        let t_us = 1_800_000_000_000_000 + 1000 * seq + whisker;
        let mut contact = json!({
            "array": "left", "whisker": whisker, "t_us": t_us, "deflection_mm": 1.5, "strain": strain, "pressure_mpa": 0.1
        });
        let (key, place) = ratio.map_or(("place", json!("UNKNOWN")), |ratio| ("ratio", json!(ratio)));
        contact[key] = place;
        contact
    };
    let contacts: Vec<Value> = (0..).zip(&values).map(|(whisker, value)| contact(whisker, *value)).collect();
    let mut messages = vec![(RobotTopic::Contacts, json!({ "boot_id": boot_id, "seq": seq, "contacts": contacts }))];
    if seq % 5 == 0 {
        let whiskers =
            json!([{ "array": "left", "whisker": 0, "pressure_mpa": 0.1, "regulator": "OK", "gauge": "OK" }]);
        let status =
            json!({ "boot_id": boot_id, "seq": seq / 5, "t_us": 1_800_000_000_000_000_i64, "whiskers": whiskers });
        messages.push((RobotTopic::Status, status));
    }
    (values, messages)
}

#[tokio::test]
async fn each_contact_is_once_in_the_table_that_the_documented_settings_write() {
    let (Some(home), Some(kafka)) = (connectors(), Kafka::start(1).await) else { return };
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("warehouse")).unwrap();
    kafka.create_topic(TOPIC, PARTITIONS).await;
    kafka.create_topic(CONTROL, 1).await;
    let _worker = Process::start(worker(&home, folder.path(), &kafka));
    let mut sent: BTreeMap<(String, i64), (u32, Values)> = BTreeMap::new();
    let what = format!("a table with all contacts; see {}", folder.path().join("log").display());
    // The connector looks at its control topic with each read, so there must be something to read.
    until_within(START, &what, async || {
        if sent.len() < MOST {
            let seq = sent.len() as i64;
            let (values, messages) = messages(seq);
            for (kind, message) in messages {
                let message = message.to_string().into_bytes();
                let topic = format!("whisker/v1/f/r/{kind}");
                receive(&Topic::parse(&topic).unwrap(), &message).unwrap();
                let partition = (seq % i64::from(PARTITIONS)) as u32;
                kafka.write(TOPIC, partition, vec![record("r", &topic, message)]).await;
            }
            sent.insert(("boot-1".to_owned(), seq), (1, values));
        }
        let stored = stored(folder.path());
        assert!(stored.values().all(|(times, _)| *times == 1), "a message is twice in the table");
        let are_known = sent.iter().take(ENOUGH).all(|(key, value)| stored.get(key) == Some(value));
        (sent.len() >= ENOUGH && are_known).then_some(())
    })
    .await;
}
