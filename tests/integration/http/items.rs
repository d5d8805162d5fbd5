//! Single rows of lists: the same content as in the list, and problems that name the unknown part.

use serde_json::json;
use vibrissa_store::secret::Secret;
use vibrissa_supervisor::http::access::AccessOptions;

use crate::served::Served;

async fn rows_are_as_in_their_lists(served: &Served) {
    let whiskers = served.items("/v1/whiskers?fleet=f&robot=r1").await;
    assert!(whiskers.len() >= 3);
    for whisker in whiskers {
        let path = format!("/v1/whiskers/f/r1/{}/{}", whisker["array"].as_str().unwrap(), whisker["whisker"]);
        assert_eq!(served.json(&path).await, whisker);
    }
    let robot = &served.items("/v1/robots?fleet=f").await[0];
    assert_eq!(&served.json(&format!("/v1/robots/f/{}", robot["robot"].as_str().unwrap())).await, robot);
    let array = &served.items("/v1/arrays?fleet=f&robot=r1").await[0];
    assert_eq!(&served.json(&format!("/v1/arrays/f/r1/{}", array["array"].as_str().unwrap())).await, array);
    for (list, column) in [
        ("alarms", "alarm_id"),
        ("trims", "trim_id"),
        ("health-changes", "health_change_id"),
        ("touch-tests", "test_id"),
    ] {
        let row = &served.items(&format!("/v1/{list}")).await[0];
        let name = row[column].as_str().map_or_else(|| row[column].to_string(), ToOwned::to_owned);
        assert_eq!(&served.json(&format!("/v1/{list}/{name}")).await, row, "{list}");
    }
}

#[tokio::test]
async fn rows_are_as_in_their_lists_on_sqlite() {
    rows_are_as_in_their_lists(&Served::sqlite().await).await;
}

#[tokio::test]
async fn rows_are_as_in_their_lists_on_postgres() {
    rows_are_as_in_their_lists(&Served::postgres().await).await;
}

#[tokio::test]
async fn a_problem_says_which_part_of_a_path_is_unknown() {
    let served = Served::sqlite().await;
    for (path, detail) in [
        ("whiskers/x/r1/left/0", "there is no fleet x"),
        ("whiskers/f/x/left/0", "the fleet f has no robot x"),
        ("whiskers/f/r1/x/0", "the robot r1 of the fleet f has no array x"),
        ("whiskers/f/r1/left/9", "the array left of the robot r1 has no whisker 9; it has 0, 1, 2"),
        ("arrays/f/r1/x", "the robot r1 of the fleet f has no array x"),
        ("arrays/f/x/left", "the fleet f has no robot x"),
        ("robots/f/x", "the fleet f has no robot x"),
        ("robots/x/r1", "there is no fleet x"),
        (
            "fleets/f/robots/r1/arrays/left/whiskers/9/contacts",
            "the array left of the robot r1 has no whisker 9; it has 0, 1, 2",
        ),
        ("fleets/f/robots/x/arrays/left/whiskers/0/what-if?length_mm=60", "the fleet f has no robot x"),
        ("alarms/77", "there is no alarm 77, or your token does not cover its fleet"),
    ] {
        let answer = served.get(&format!("/v1/{path}")).await;
        assert_eq!((answer.status, &answer.json()["detail"]), (404, &json!(detail)), "{path}");
    }
    let answer = served.get("/v1/whiskers/f/r1/left/x").await;
    assert_eq!(answer.status, 422, "{}", answer.body);
}

#[tokio::test]
async fn the_document_requires_a_token_exactly_if_the_service_does() {
    let security = async |served: &Served| served.json("/openapi.json").await["security"].clone();
    assert_eq!(security(&Served::sqlite().await).await, json!([{}, { "token": [] }]));
    let token = Secret::new("a-token-of-more-than-32-characters-for-the-test");
    let closed = Served::to(&AccessOptions { token: Some(token), oidc: None }).await;
    assert_eq!(security(&closed).await, json!([{ "token": [] }]));
}

#[tokio::test]
async fn a_page_refers_to_the_schema_of_its_rows() {
    let document = Served::sqlite().await.json("/openapi.json").await;
    let mut pages = 0;
    for (name, schema) in document["components"]["schemas"].as_object().unwrap() {
        let Some(item) = name.strip_prefix("Page_").or_else(|| name.strip_prefix("Groups_")) else { continue };
        pages += 1;
        assert_eq!(schema["properties"]["items"]["items"], json!({ "$ref": format!("#/components/schemas/{item}") }));
        assert!(document["components"]["schemas"][item]["properties"].is_object(), "{item}");
    }
    assert!(pages >= 15, "{pages}");
}
