//! A token for one fleet shows nothing of other fleets.

use vibrissa_supervisor::http::access::token::{NewToken, create};
use vibrissa_supervisor::http::access::{Role, Scope};
use vibrissa_tests::web::ask;

use crate::document::{Document, NAMED_ROWS, get_operations, required_query};
use crate::served::Served;

#[tokio::test]
async fn a_caller_with_one_fleet_sees_nothing_of_another() {
    let served = Served::sqlite().await;
    let new = NewToken {
        name: "one".to_owned(),
        role: Role::Viewer,
        scope: Scope::of(["g".parse().unwrap()]),
        expires_us: i64::MAX,
        created_by: "test".to_owned(),
    };
    let (token, _) = create(&served.store, &new, 0).await.unwrap();
    let bearer = format!("Bearer {token}");
    let get = async |path: &str| ask(served.http, "GET", path, &[("Authorization", &bearer)]).await.unwrap();

    let document = Document::of(&served).await;
    let mut lists = 0;
    for (path, operation) in get_operations(&document.0) {
        if document.words(operation, "sort").is_some() && !path.contains('{') {
            let items = get(&format!("{path}?limit=1000")).await.json()["items"].as_array().unwrap().clone();
            let is_of_fleets = items.first().is_some_and(|item| item.get("fleet").is_some());
            lists += usize::from(is_of_fleets);
            assert!(!is_of_fleets || items.iter().all(|item| item["fleet"] == "g"), "{path}");
        }
    }
    assert!(lists >= 10);
    let whiskers = get("/v1/errors/by-whisker").await.json()["items"].as_array().unwrap().clone();
    assert!(!whiskers.is_empty() && whiskers.iter().all(|item| item["fleet"] == "g"));
    for group in ["by-case", "by-ratio", "by-time"] {
        let mine = get(&format!("/v1/errors/{group}")).await.json();
        assert_eq!(mine, served.json(&format!("/v1/errors/{group}?fleet=g")).await, "{group}");
        assert_ne!(mine, served.json(&format!("/v1/errors/{group}")).await, "{group}");
    }

    let id_of = async |list: &str, field: &str, fleet: &str| {
        let item = served.items(&format!("/v1/{list}?fleet={fleet}")).await[0][field].clone();
        item.as_str().map_or_else(|| item.to_string(), ToOwned::to_owned)
    };
    // The robots of these fleets have no black box.
    for (list, field) in NAMED_ROWS.into_iter().filter(|(list, _)| *list != "black-boxes") {
        let path = |id: String| format!("/v1/{list}/{id}");
        assert_eq!(get(&path(id_of(list, field, "g").await)).await.status, 200, "{list}");
        assert_eq!(get(&path(id_of(list, field, "f").await)).await.status, 404, "{list}");
    }
    for (path, _) in get_operations(&document.0).filter(|(path, _)| path.contains("{fleet}")) {
        let path =
            path.replace("{fleet}", "f").replace("{robot}", "r1").replace("{array}", "left").replace("{whisker}", "0");
        let answer = get(&(path.clone() + required_query(&path))).await;
        assert_eq!(answer.status, 403, "{path}");
    }
}
