//! Every route with every method: only callers with the required role are admitted.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;
use vibrissa_tests::web::{Answer, ask, open};

use crate::started::{EmptyDatabase, ROOT, Started};

const METHODS: [&str; 8] = ["GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS", "TRACE"];
/// Public paths, which contain no data of fleets.
const PUBLIC: [&str; 6] = ["/", "/console/main.js", "/openapi.json", "/problems/forbidden", "/livez", "/readyz"];
/// Roles in ascending order; each includes the rights of the earlier ones.
const ROLES: [&str; 4] = ["VIEWER", "OPERATOR", "ENGINEER", "ADMIN"];

/// Each path of the OpenAPI document with its methods and their roles.
async fn declared(started: &Started) -> BTreeMap<String, BTreeMap<String, String>> {
    let document: Value = started.get("/openapi.json", &[]).await.json();
    let role = |operation: &Value| operation["x-required-role"].as_str().unwrap().to_owned();
    let methods = |item: &Value| {
        let operations = item.as_object().unwrap().iter().filter(|(name, _)| *name != "parameters");
        operations.map(|(name, operation)| (name.to_ascii_uppercase(), role(operation))).collect()
    };
    let paths = document["paths"].as_object().unwrap().iter();
    paths.map(|(path, item)| (path.clone(), methods(item))).collect()
}

/// Fills each parameter of a path for fleet `f` with names that do not exist.
fn filled(path: &str) -> String {
    let mut filled = path.replace("{fleet}", "f").replace("{array}", "left").replace("{robot}", "nobody");
    while let Some((before, rest)) = filled.split_once('{') {
        let after = rest.split_once('}').unwrap().1;
        filled = format!("{before}0{after}");
    }
    filled
}

async fn asked(started: &Started, method: &str, path: &str, token: Option<&str>) -> Answer {
    let bearer = token.map(|token| format!("Bearer {token}"));
    let headers: Vec<(&str, &str)> = bearer.iter().map(|bearer| ("Authorization", bearer.as_str())).collect();
    // A stream does not end, so only its status is read.
    if (method, path) == ("GET", "/v1/events") {
        let (status, _) = open(started.http, path, &headers).await.unwrap();
        return Answer { status, headers: BTreeMap::new(), body: String::new() };
    }
    ask(started.http, method, path, &headers).await.unwrap()
}

async fn every_method_of_every_route(place: &EmptyDatabase) {
    let mut callers = vec![(None, true, None), (Some("ADMIN"), true, Some(ROOT.to_owned()))];
    for role in ["viewer", "operator", "engineer", "admin"] {
        for (covers, fleet) in [(true, "f"), (false, "g")] {
            let token = place.token(role, &["--fleet", fleet]);
            callers.push((ROLES.iter().copied().find(|word| word.eq_ignore_ascii_case(role)), covers, Some(token)));
        }
    }
    let started = place.start_closed(&["--fleets", "f,g"]);
    let declared = declared(&started).await;
    assert!(declared.len() > 40, "{}", declared.len());
    let rank = |word: &str| ROLES.iter().position(|role| *role == word).unwrap();
    for (path, methods) in &declared {
        assert!(path.starts_with("/v1/"), "{path}");
        let filled = filled(path);
        let is_of_fleet = path.contains("{fleet}");
        for method in METHODS {
            let needed = methods.get(if method == "HEAD" { "GET" } else { method });
            for (role, covers, token) in &callers {
                let answer = asked(&started, method, &filled, token.as_deref()).await;
                let status = answer.status;
                let what = format!("{method} {filled} as {role:?}, its fleet: {covers}: {status} {}", answer.body);
                match (role, needed) {
                    (None, _) => assert_eq!(status, 401, "{what}"),
                    (Some(_), None) => {
                        assert_eq!(status, 405, "{what}");
                        let allowed: BTreeSet<&str> = answer.headers["allow"].split(',').collect();
                        let get = methods.contains_key("GET").then_some("HEAD");
                        let expected: BTreeSet<&str> = methods.keys().map(String::as_str).chain(get).collect();
                        assert_eq!(allowed, expected, "{what}");
                    }
                    (Some(role), Some(needed)) if rank(role) < rank(needed) => assert_eq!(status, 403, "{what}"),
                    (Some(_), Some(_)) if is_of_fleet && !covers => assert_eq!(status, 403, "{what}"),
                    (Some(_), Some(_)) => assert!(!matches!(status, 401 | 403 | 405 | 500), "{what}"),
                }
            }
        }
    }
}

#[tokio::test]
async fn every_method_of_every_route_lets_in_its_role_only_on_sqlite() {
    every_method_of_every_route(&EmptyDatabase::sqlite()).await;
}

#[tokio::test]
async fn every_method_of_every_route_lets_in_its_role_only_on_postgres() {
    every_method_of_every_route(&EmptyDatabase::postgres().await).await;
}

#[tokio::test]
async fn nothing_is_served_beside_the_routes() {
    let place = EmptyDatabase::sqlite();
    let started = place.start_closed(&["--fleets", "f"]);
    for path in PUBLIC {
        assert!(matches!(started.get(path, &[]).await.status, 200 | 503), "{path}");
    }
    // Alternative spellings of a path must not bypass the check.
    for path in [
        "/v1",
        "/v1/",
        "/V1/fleets",
        "//v1/fleets",
        "/v1//fleets",
        "/v1/fleets/",
        "/v1/./fleets",
        "/x/../v1/fleets",
        "/%76%31/fleets",
        "/v1%2ffleets",
        "/v1/fleets;x",
        "/console/../v1/fleets",
        "/console/%2e%2e/v1/fleets",
    ] {
        let status = started.get(path, &[]).await.status;
        assert!(matches!(status, 400 | 401 | 404), "{path}: {status}");
        let bearer = format!("Bearer {ROOT}");
        let status = started.get(path, &[("Authorization", &bearer)]).await.status;
        assert!(matches!(status, 400 | 404), "{path} with every right: {status}");
    }
}
