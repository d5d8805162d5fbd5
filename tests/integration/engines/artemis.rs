//! Apache Artemis: one broker, or a pair on a shared store.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;
use vibrissa_tests::installed::{installed, listens};
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::process::{Launch, Process};

use crate::engine::{ALL, FEW, PASSWORD};

/// Running brokers; killed on drop. In a pair the first is the primary, and the second listens only after its failure.
pub(crate) struct Artemis {
    pub(crate) brokers: Vec<Process>,
    pub(crate) ports: Vec<u16>,
    folder: TempDir,
}

/// Ports of a broker: MQTT, and the core protocol of the pair.
#[derive(Debug, Clone, Copy)]
struct Ports {
    mqtt: u16,
    core: u16,
}

impl Artemis {
    /// Starts one broker; `None` if Artemis is not installed.
    pub(crate) fn start() -> Option<Self> {
        Self::start_all(1)
    }

    /// Starts a primary and a backup, and returns when the backup waits for the primary's failure.
    pub(crate) fn start_pair() -> Option<Self> {
        let pair = Self::start_all(2)?;
        let log = pair.folder.path().join("1/log");
        let waits = || fs::read_to_string(&log).unwrap_or_default().contains("AMQ221032");
        let begun = std::time::Instant::now();
        while !waits() {
            assert!(begun.elapsed().as_secs() < 60, "no backup: {}", fs::read_to_string(&log).unwrap_or_default());
            std::thread::sleep(std::time::Duration::from_millis(50));
        }
        Some(pair)
    }

    fn start_all(count: usize) -> Option<Self> {
        let home = installed("artemis", Some("--if-installed"))?;
        for _ in 0..3 {
            if let Some(started) = Self::try_start(&home, count) {
                return Some(started);
            }
        }
        panic!("Artemis did not start");
    }

    fn try_start(home: &Path, count: usize) -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let ports: Vec<Ports> = (0..count).map(|_| Ports { mqtt: free_port(), core: free_port() }).collect();
        let mut brokers = Vec::new();
        for at in 0..count {
            let instance = folder.path().join(at.to_string());
            configure(&instance, at, &ports, folder.path());
            brokers.push(Process::start(launch(home, &instance)));
            if at == 0 && !listens("127.0.0.1", ports[0].mqtt, || brokers[0].ended_already().is_some()) {
                let log = fs::read_to_string(instance.join("log")).unwrap_or_default();
                eprintln!("{}", log.lines().take(40).collect::<Vec<_>>().join("\n"));
                return None;
            }
        }
        Some(Self { brokers, ports: ports.iter().map(|ports| ports.mqtt).collect(), folder })
    }
}

fn launch(home: &Path, instance: &Path) -> Launch {
    let etc = instance.join("etc");
    let property = |name: &str, path: &Path| format!("-D{name}={}", path.display());
    let arguments = vec![
        "-Xms64M".to_owned(),
        "-Xmx256M".to_owned(),
        // They shorten the start.
        "-XX:+UseSerialGC".to_owned(),
        "-XX:TieredStopAtLevel=1".to_owned(),
        "-Dlog4j2.disableJmx=true".to_owned(),
        property("log4j2.configurationFile", &etc.join("log4j2.properties")),
        "--add-opens=java.base/jdk.internal.misc=ALL-UNNAMED".to_owned(),
        property("java.security.auth.login.config", &etc.join("login.config")),
        property("artemis.home", home),
        property("artemis.instance", instance),
        property("artemis.instance.etc", &etc),
        property("data.dir", &instance.join("data")),
        property("java.io.tmpdir", &instance.join("tmp")),
        "-cp".to_owned(),
        home.join("lib/artemis-boot.jar").display().to_string(),
        "org.apache.activemq.artemis.boot.Artemis".to_owned(),
        "run".to_owned(),
    ];
    Launch { program: PathBuf::from("java"), arguments, environment: Vec::new(), log: instance.join("log") }
}

fn configure(instance: &Path, at: usize, ports: &[Ports], shared: &Path) {
    let etc = instance.join("etc");
    for folder in [&etc, &instance.join("tmp"), &instance.join("data")] {
        fs::create_dir_all(folder).unwrap();
    }
    let write = |name: &str, text: &str| fs::write(etc.join(name), text).unwrap();
    write("broker.xml", &broker_xml(at, ports, &shared.join("store")));
    write("management.xml", r#"<management-context xmlns="http://activemq.apache.org/schema"/>"#);
    let bootstrap = format!(
        r#"<broker xmlns="http://activemq.apache.org/schema"><jaas-security domain="activemq"/><server configuration="file:{}"/></broker>"#,
        etc.join("broker.xml").display()
    );
    write("bootstrap.xml", &bootstrap);
    let module = "org.apache.activemq.artemis.spi.core.security.jaas.PropertiesLoginModule";
    let login = format!(
        "activemq {{ {module} required org.apache.activemq.jaas.properties.user=\"artemis-users.properties\" \
         org.apache.activemq.jaas.properties.role=\"artemis-roles.properties\"; }};"
    );
    write("login.config", &login);
    write("artemis-users.properties", &format!("{ALL}={PASSWORD}\n{FEW}={PASSWORD}\n"));
    write("artemis-roles.properties", &format!("{ALL}={ALL}\n{FEW}={FEW}\n"));
    let log = "rootLogger.level = INFO\nrootLogger.appenderRef.err.ref = err\nappender.err.type = Console\n\
               appender.err.name = err\nappender.err.target = SYSTEM_ERR\nappender.err.layout.type = PatternLayout\n\
               appender.err.layout.pattern = %d %p %m%n\n";
    write("log4j2.properties", log);
}

fn broker_xml(at: usize, ports: &[Ports], store: &Path) -> String {
    let Ports { mqtt, core } = ports[at];
    let store = store.display();
    let pair = ports.get(1 - at).map_or_else(String::new, |other| {
        let role = if at == 0 {
            "<primary><failover-on-shutdown>true</failover-on-shutdown></primary>"
        } else {
            "<backup><allow-failback>false</allow-failback></backup>"
        };
        format!(
            r#"<connectors><connector name="own">tcp://127.0.0.1:{core}</connector>
<connector name="other">tcp://127.0.0.1:{}</connector></connectors>
<cluster-user>pair</cluster-user><cluster-password>{PASSWORD}</cluster-password>
<ha-policy><shared-store>{role}</shared-store></ha-policy>
<cluster-connections><cluster-connection name="pair"><connector-ref>own</connector-ref>
<static-connectors><connector-ref>other</connector-ref></static-connectors></cluster-connection></cluster-connections>
"#,
            other.core
        )
    });
    let acceptor = if pair.is_empty() {
        String::new()
    } else {
        format!(r#"<acceptor name="core">tcp://127.0.0.1:{core}?protocols=CORE</acceptor>"#)
    };
    let permissions = |roles: &str| {
        [
            "createNonDurableQueue",
            "deleteNonDurableQueue",
            "createDurableQueue",
            "deleteDurableQueue",
            "createAddress",
            "deleteAddress",
            "consume",
            "browse",
            "send",
        ]
        .map(|kind| format!(r#"<permission type="{kind}" roles="{roles}"/>"#))
        .concat()
    };
    let (every, own) = (permissions(ALL), permissions(&format!("{ALL},{FEW}")));
    format!(
        r##"<configuration xmlns="urn:activemq"><core xmlns="urn:activemq:core">
<name>vibrissa</name>
<journal-type>NIO</journal-type>
<journal-datasync>false</journal-datasync>
<journal-file-size>1M</journal-file-size>
<max-disk-usage>100</max-disk-usage>
<paging-directory>{store}/paging</paging-directory><bindings-directory>{store}/bindings</bindings-directory>
<journal-directory>{store}/journal</journal-directory><large-messages-directory>{store}/large</large-messages-directory>
{pair}
<acceptors>{acceptor}
<acceptor name="mqtt">tcp://127.0.0.1:{mqtt}?protocols=MQTT;tcpNoDelay=true;closeMqttConnectionOnPublishAuthorizationFailure=false</acceptor></acceptors>
<security-settings>
<security-setting match="#">{every}</security-setting>
<security-setting match="whisker.v1.f.{FEW}.#">{own}</security-setting>
</security-settings>
<address-settings><address-setting match="#"><auto-create-queues>true</auto-create-queues>
<auto-create-addresses>true</auto-create-addresses><auto-delete-addresses>false</auto-delete-addresses>
<auto-delete-queues>false</auto-delete-queues></address-setting></address-settings>
</core></configuration>
"##
    )
}
