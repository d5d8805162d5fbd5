//! Runs the demo like a new user.

mod live;
mod pictures;

use vibrissa_lab::demo::{DemoOptions, Serving, run};
use vibrissa_tests::svg::is_up_to_date;

/// The demo itself fails if a trim was missed, late or false, a length off by more than 1 mm, a setpoint not applied, a
/// contact lost, or the mean error of self-compensation not below the
/// paper's 20.385 % by air alone and 6 % with a gain.
#[tokio::test(flavor = "multi_thread")]
async fn paper_the_demo_ends_as_expected() {
    let folder = tempfile::tempdir().unwrap();
    let options = DemoOptions {
        folder: folder.path().to_owned(),
        seed: 2021,
        mqtt_port: 0,
        http: "127.0.0.1:0".parse().unwrap(),
        serving: Serving::Never,
        opens_browser: false,
    };
    assert!(run(&options).await.unwrap(), "see the report above");
    let picture = std::fs::read_to_string(folder.path().join("demo.svg")).unwrap();
    assert!(picture.contains("crawler-2/nose/1"), "the chart must name the whiskers");
    is_up_to_date("demo.svg", &picture, "cargo test -p vibrissa-tests --test demo the_demo_ends");
    assert!(folder.path().join("demo.sqlite3").is_file());
}
