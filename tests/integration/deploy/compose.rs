//! Checks of `docker-compose.yml` as docker-compose resolves it.

use std::collections::BTreeMap;
use std::process::{Command, Stdio};
use std::sync::LazyLock;

use serde_json::Value;

use crate::project;

/// The resolved file. Version 2 prints JSON. Version 1 prints YAML, but installs a YAML reader for the system's Python.
static RESOLVED: LazyLock<Value> = LazyLock::new(|| {
    let compose = |arguments: &[&str]| {
        let mut command = Command::new("docker-compose");
        command.args(arguments).current_dir(project()).output().expect("docker-compose must be installed for this test")
    };
    let ended = compose(&["config", "--format", "json"]);
    if ended.status.success() && !ended.stdout.is_empty() {
        return serde_json::from_slice(&ended.stdout).unwrap();
    }
    let ended = compose(&["config"]);
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let mut python = Command::new("/usr/bin/python3")
        .args(["-c", "import json, sys, yaml; json.dump(yaml.safe_load(sys.stdin), sys.stdout)"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    std::io::Write::write_all(&mut python.stdin.take().unwrap(), &ended.stdout).unwrap();
    serde_json::from_slice(&python.wait_with_output().unwrap().stdout).unwrap()
});

pub(crate) fn services() -> BTreeMap<&'static str, &'static Value> {
    RESOLVED["services"].as_object().unwrap().iter().map(|(name, service)| (name.as_str(), service)).collect()
}

fn texts(value: &Value) -> Vec<&str> {
    value.as_array().map(|items| items.iter().filter_map(Value::as_str).collect()).unwrap_or_default()
}

#[test]
fn it_has_what_it_promises() {
    let expected =
        ["broker", "grafana", "grafana-role", "postgres", "prometheus", "simulator", "supervisor-1", "supervisor-2"];
    assert_eq!(services().into_keys().collect::<Vec<_>>(), expected);
}

#[test]
fn every_image_is_pinned() {
    for (name, service) in services() {
        let image = service["image"].as_str().unwrap();
        let (_, tag) = image.rsplit_once(':').unwrap_or_else(|| panic!("{name}: {image} has no tag"));
        let is_version = tag.trim_start_matches('v').split(['.', '-']).take(2).all(|part| part.parse::<u32>().is_ok());
        assert!(is_version, "{name}: the tag of {image} is not a fixed version");
    }
}

#[test]
fn no_service_is_root_or_can_become_it_or_write_to_its_image() {
    for (name, service) in services() {
        let user = service["user"].as_str().unwrap_or_else(|| panic!("{name} has no user"));
        assert!(user.split(':').next().unwrap().parse::<u32>().unwrap() > 0, "{name}: {user}");
        assert_eq!(texts(&service["cap_drop"]), ["ALL"], "{name}");
        assert_eq!(texts(&service["security_opt"]), ["no-new-privileges:true"], "{name}");
        assert_eq!(service["read_only"], true, "{name}");
        assert!(service.get("privileged").is_none() && service.get("cap_add").is_none(), "{name}");
    }
}

#[test]
fn every_service_that_can_be_asked_for_its_health_is() {
    for (name, service) in services() {
        // The simulator exits on failure; the role's service exits when it is done.
        let is_asked = !["simulator", "grafana-role"].contains(&name);
        assert_eq!(service.get("healthcheck").is_some(), is_asked, "{name}");
    }
    let prometheus = std::fs::read_to_string(project().join("deploy/prometheus/prometheus.yml")).unwrap();
    let image = std::fs::read_to_string(project().join("Dockerfile")).unwrap();
    assert!(image.contains("VIBRISSA_HTTP_MONITORING_LISTEN=0.0.0.0:9464"), "{image}");
    for supervisor in ["supervisor-1", "supervisor-2"] {
        assert!(prometheus.contains(&format!("{supervisor}:9464")), "{supervisor} is not scraped");
    }
}

#[test]
fn two_supervisors_share_all_but_their_names_and_ports() {
    let services = services();
    let [first, second] = ["supervisor-1", "supervisor-2"].map(|name| services[name].as_object().unwrap().clone());
    for (key, value) in &first {
        let own = ["hostname", "ports", "build", "depends_on"].contains(&key.as_str());
        assert_eq!(second.get(key) != Some(value), own, "{key}");
    }
    assert_eq!(first["environment"]["VIBRISSA_DATABASE_URL"], "postgres://supervisor@postgres:5432/vibrissa");
    assert_eq!(first["environment"]["VIBRISSA_MQTT_URL"], "mqtt://broker:1884", "the supervisors' listener");
}

/// Newer versions of Compose refuse two builds of the same image.
#[test]
fn regress_each_image_is_built_once_and_nothing_built_is_fetched() {
    let mut built = BTreeMap::new();
    for (name, service) in services().into_iter().filter(|(_, service)| service.get("build").is_some()) {
        let twice = built.insert(service["image"].as_str().unwrap(), name);
        assert_eq!(twice, None, "{name}");
    }
    for (name, service) in services() {
        let image = service["image"].as_str().unwrap();
        if image.starts_with("vibrissa") && service.get("build").is_none() {
            assert_eq!(service["pull_policy"], "never", "{name}");
            assert!(service["depends_on"].get(built[image]).is_some(), "{name} may start before {image} is built");
        }
    }
    assert_eq!(built.keys().copied().collect::<Vec<_>>(), ["vibrissa-lab:0.2.0", "vibrissa:0.2.0"]);
}

#[test]
fn regress_every_log_is_limited() {
    for (name, service) in services() {
        let options = service["logging"]["options"].as_object().unwrap_or_else(|| panic!("{name}: {service}"));
        assert_eq!(service["logging"]["driver"], "json-file", "{name}");
        assert!(options.contains_key("max-size") && options.contains_key("max-file"), "{name}: {options:?}");
    }
}

/// For a folder that an image declares as a volume, Docker creates an anonymous volume unless the file mounts something
/// there. Such a volume remains after `down`.
#[test]
fn regress_no_image_leaves_an_anonymous_volume() {
    for (name, folders) in [
        ("broker", &["/mosquitto/data", "/mosquitto/log"][..]),
        ("postgres", &["/var/lib/postgresql/data"]),
        ("grafana-role", &["/var/lib/postgresql/data"]),
        ("prometheus", &["/prometheus"]),
    ] {
        let service = services()[name];
        let volumes = service["volumes"].as_array().into_iter().flatten();
        let mut mounted: Vec<&str> = volumes
            .map(|volume| match volume.as_str() {
                Some(text) => text.split(':').nth(1).unwrap(),
                None => volume["target"].as_str().unwrap(),
            })
            .collect();
        mounted.extend(texts(&service["tmpfs"]).into_iter().map(|tmpfs| tmpfs.split(':').next().unwrap()));
        for folder in folders {
            assert!(mounted.contains(folder), "{name}: {folder} is not among {mounted:?}");
        }
    }
}

#[test]
fn folders_in_memory_say_whose_they_are() {
    for (name, service) in services() {
        for folder in texts(&service["tmpfs"]) {
            let (path, options) = folder.split_once(':').unwrap_or_else(|| panic!("{name}: {folder} has no options"));
            let has = |option: &str| options.split(',').any(|one| one.starts_with(option));
            assert!(has("mode=") && (path == "/tmp" || (has("uid=") && has("gid="))), "{name}: {folder}");
        }
    }
}

#[test]
fn the_broker_gets_its_access_list_as_a_secret() {
    let broker = services()["broker"];
    let targets: Vec<&str> =
        broker["secrets"].as_array().unwrap().iter().map(|one| one["target"].as_str().unwrap()).collect();
    let configuration = std::fs::read_to_string(project().join("deploy/mosquitto/mosquitto.conf")).unwrap();
    for line in configuration.lines().filter(|line| line.contains("_file ")) {
        let (_, path) = line.split_once(' ').unwrap();
        assert!(targets.contains(&path), "{line} is not among {targets:?}");
    }
}

/// PostgreSQL's image runs the scripts of that folder in a new database.
#[test]
fn the_database_makes_the_supervisors_role() {
    let postgres = services()["postgres"];
    let mounted = postgres["volumes"].as_array().unwrap().iter().any(|volume| {
        let text = volume.to_string();
        text.contains("deploy/postgres/supervisor.sql") && text.contains("/docker-entrypoint-initdb.d/supervisor.sql")
    });
    assert!(mounted, "{postgres}");
    let password = postgres["environment"]["SUPERVISOR_PASSWORD_FILE"].as_str().unwrap();
    assert_eq!(password, "/run/secrets/postgres_supervisor_password");
    assert!(postgres["secrets"].to_string().contains("postgres_supervisor_password"));
}

#[test]
fn the_simulators_state_outlives_its_container() {
    let simulator = services()["simulator"];
    let file = simulator["environment"]["VIBRISSA_STATE_FILE"].as_str().unwrap();
    let folder = file.rsplit_once('/').unwrap().0;
    assert!(simulator["volumes"].to_string().contains(folder), "{simulator}");
}

#[test]
fn ports_are_only_published_to_this_host() {
    for (name, service) in services() {
        for port in service["ports"].as_array().into_iter().flatten() {
            // Version 1 prints a text, version 2 an object.
            let is_local = match port.as_str() {
                Some(text) => text.starts_with("127.0.0.1:"),
                None => port["host_ip"] == "127.0.0.1",
            };
            assert!(is_local, "{name}: {port}");
        }
    }
}

#[test]
fn no_password_is_written_down() {
    for (name, service) in services() {
        for (variable, value) in service["environment"].as_object().into_iter().flatten() {
            let is_secret = ["PASSWORD", "SECRET", "TOKEN"].iter().any(|word| variable.contains(word));
            let value = value.as_str().unwrap_or_default();
            assert!(!is_secret || value.starts_with("/run/secrets/"), "{name}: {variable}");
            let user = value.split_once("://").and_then(|(_, rest)| rest.split_once('@')).map(|(user, _)| user);
            assert!(user.is_none_or(|user| !user.contains(':')), "{name}: {variable} has a password");
        }
    }
    let ignored = std::fs::read_to_string(project().join(".gitignore")).unwrap();
    assert!(ignored.lines().any(|line| line == "deploy/secrets/"));
    for (name, secret) in RESOLVED["secrets"].as_object().unwrap() {
        let file = secret["file"].as_str().unwrap_or_else(|| panic!("{name} is not a file"));
        assert!(file.ends_with(&format!("deploy/secrets/{name}")), "{file}");
    }
}

#[test]
fn what_is_mounted_from_here_is_read_only() {
    for (name, service) in services() {
        for volume in service["volumes"].as_array().into_iter().flatten() {
            let is_fine = match volume.as_str() {
                Some(text) => !text.starts_with('/') || text.ends_with(":ro"),
                None => volume["type"] != "bind" || volume["read_only"] == true,
            };
            assert!(is_fine, "{name}: {volume}");
        }
    }
    for (name, volume) in RESOLVED["volumes"].as_object().unwrap() {
        assert!(volume.get("external").is_none(), "{name}");
    }
}

#[test]
fn grafana_opens_on_a_dashboard_and_reads_with_a_role_of_its_own() {
    let grafana = services()["grafana"];
    let mounted = |path: &str| {
        let inside = path.strip_prefix("/etc/vibrissa/").unwrap_or_else(|| panic!("{path} is not mounted"));
        std::fs::read_to_string(project().join(inside)).unwrap_or_else(|problem| panic!("{path}: {problem}"))
    };
    let home = grafana["environment"]["GF_DASHBOARDS_DEFAULT_HOME_DASHBOARD_PATH"].as_str().unwrap();
    assert!(mounted(home).contains("\"uid\": \"vibrissa-fleet\""));
    let source = mounted("/etc/vibrissa/dashboards/provisioning/datasources/postgres.yml");
    let password = source.split("password: $__file{/run/secrets/").nth(1).and_then(|rest| rest.split('}').next());
    let secrets = |service: &Value| {
        let named = service["secrets"].as_array().unwrap().iter();
        named.map(|one| one["source"].as_str().or(one.as_str()).unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(secrets(grafana), [password.unwrap()]);
    assert!(source.contains("user: grafana\n") && source.contains("type: grafana-postgresql-datasource\n"));
    let role = services()["grafana-role"];
    let its_password = role["environment"]["GRAFANA_PASSWORD_FILE"].as_str().unwrap();
    assert!(secrets(role).iter().any(|one| its_password == format!("/run/secrets/{one}")), "{its_password}");
}

/// Without this a build fails only where somebody makes images.
#[test]
fn the_context_of_the_images_has_all_crates_and_copied_files() {
    let ignored = std::fs::read_to_string(project().join(".dockerignore")).unwrap();
    let sent: Vec<&str> = ignored.lines().filter_map(|line| line.strip_prefix('!')).collect();
    let mut needed: Vec<String> = Vec::new();
    for workspace in ["", "robot/"] {
        let manifest = std::fs::read_to_string(project().join(format!("{workspace}Cargo.toml"))).unwrap();
        let manifest: toml::Table = manifest.parse().unwrap();
        let members = manifest["workspace"]["members"].as_array().unwrap().iter();
        needed.extend(members.map(|member| format!("{workspace}{}", member.as_str().unwrap())));
        needed.extend(["Cargo.toml", "Cargo.lock"].map(|file| format!("{workspace}{file}")));
    }
    let image = std::fs::read_to_string(project().join("Dockerfile")).unwrap();
    let copied =
        image.lines().filter_map(|line| line.strip_prefix("COPY ")).filter(|words| !words.starts_with("--from"));
    needed.extend(copied.map(|words| words.split(' ').next().unwrap().to_owned()).filter(|path| path != "."));
    assert!(needed.len() > 18, "{needed:?}");
    for path in needed {
        let is_sent = sent.iter().any(|one| path == *one || path.starts_with(&format!("{one}/")));
        assert!(is_sent, ".dockerignore leaves out {path}");
    }
}

#[test]
fn each_image_builds_its_own_programs_and_is_named_at_the_top() {
    let image = std::fs::read_to_string(project().join("Dockerfile")).unwrap().replace("\\\n", " ");
    let stage = |name: &str| image.split(&format!(" AS {name}\n")).nth(1).unwrap().split("\nFROM ").next().unwrap();
    let mut copied = Vec::new();
    for name in ["supervisor", "lab", "robot"] {
        let build = stage(&format!("build-{name}"));
        let from = format!("COPY --from=build-{name} ");
        let copy = stage(name).lines().find_map(|line| line.strip_prefix(&from)).unwrap();
        for program in copy.split(' ').filter_map(|word| word.strip_prefix("/out/")) {
            assert!(build.contains(&format!("-p {program} ")), "{program}: {build}");
            assert!(
                build.split_whitespace().any(|word| word == format!("target/dist/{program}")),
                "{program}: {build}"
            );
            copied.push(program);
        }
    }
    assert_eq!(copied, ["vibrissa", "vibrissa-lab", "vibrissa-simulator", "vibrissa-robot"]);
    let targets = image.lines().filter_map(|line| line.strip_prefix("FROM runtime AS "));
    targets.for_each(|target| assert!(image.contains(&format!("docker build --target {target} ")), "{target}"));
}
