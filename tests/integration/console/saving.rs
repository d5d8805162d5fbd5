//! Lists saved as CSV files: all rows that the filters of the address show.

use serde_json::json;
use vibrissa_supervisor::http::access::Role;

use crate::checks::complaints;
use crate::notes::{DIALOG, press, send};
use crate::signing_in::{sign_in, token};
use crate::stage::Stage;

#[tokio::test]
async fn a_list_is_saved_as_csv_with_its_filter_with_and_without_a_token() {
    let mut stage = Stage::closed().await;
    let secret = token(&stage, Role::Operator, i64::MAX).await;
    stage.open("#/audit").await;
    sign_in(&mut stage, &secret).await;
    let link = "document.getElementById('save-csv')";
    stage.open("#/fleets/f/robots/r").await;
    for text in ["First", "Second"] {
        press(&mut stage, "Add a note").await;
        stage.browser.js(&format!("{DIALOG}.querySelector('textarea').value = '{text}'")).await;
        send(&mut stage).await;
    }
    press(&mut stage, "Set a label").await;
    stage.browser.js(&format!("{DIALOG}.querySelector('[name=key]').value = 'hall'")).await;
    stage.browser.js(&format!("{DIALOG}.querySelector('[name=value]').value = '2'")).await;
    send(&mut stage).await;
    // The page asks with its token for what a click saves.
    let keep = "(() => { const create = URL.createObjectURL; \
                URL.createObjectURL = (blob) => { window.saved = blob.text(); return create.call(URL, blob); }; })()";
    stage.browser.js(keep).await;
    for (hash, present, absent) in [
        ("#/audit?kind=NOTE_ADD", "First", "LABEL_SET"),
        ("#/audit?kind=LABEL_SET", "LABEL_SET", "First"),
        ("#/audit?kind=NOTE_ADD&q=second", "Second", "First"),
    ] {
        stage.browser.js(&format!("window.saved = null; location.hash = '{hash}'")).await;
        stage.browser.shown().await;
        let filter = hash.split_once('?').unwrap().1;
        stage.browser.until("the link", &format!("{link}?.href.includes('{filter}')")).await;
        stage.browser.click(link).await;
        let until = "new Promise((done) => { const look = () => window.saved ? done(window.saved) : setTimeout(look, 20); look(); })";
        let csv = stage.browser.js(until).await.as_str().unwrap().to_owned();
        assert!(csv.starts_with("action_id,") && csv.contains(present) && !csv.contains(absent), "{hash}: {csv}");
    }
    // Each list has such a link; its name is that of the list.
    for (hash, name) in [
        ("#/fleets/f", "robots.csv"),
        ("#/whiskers", "whiskers.csv"),
        ("#/whiskers?condition=TRIMMED", ""),
        ("#/audit", "audit.csv"),
    ] {
        stage.browser.js(&format!("location.hash = '{hash}'")).await;
        stage.browser.shown().await;
        stage.browser.until(hash, &format!("({link}?.download ?? '') === '{name}'")).await;
    }
    stage.stop().await;

    // Without a token it is a plain link: with all filters, and without the page of the list.
    let mut stage = Stage::start().await;
    stage.open("#/whiskers?q=r&sort=length_mm&order=descending").await;
    let href = stage.browser.js(&format!("{link}.getAttribute('href')")).await;
    assert_eq!(href, json!("v1/whiskers?q=r&sort=length_mm&order=descending&format=csv"));
    let csv = stage.browser.js(&format!("fetch({link}.href).then((answer) => answer.text())")).await;
    let csv = csv.as_str().unwrap();
    assert_eq!(csv.lines().count(), 4, "{csv}");
    let complaints = complaints(&mut stage.browser).await;
    assert_eq!(complaints, Vec::<String>::new());
    stage.is_clean();
    stage.stop().await;
}
