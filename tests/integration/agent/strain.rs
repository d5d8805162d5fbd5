//! A board that sends samples of strain: the segmenter's contacts are recorded, and a cut is found by them.

use std::time::Duration;

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use vibrissa_tests::wait::until_within;

use crate::stage::{Stage, sampling_board};

/// Time limit for the contacts that the supervisor needs: some hundred at two a second.
const LONG: Duration = Duration::from_secs(180);

#[tokio::test(flavor = "multi_thread")]
async fn a_cut_is_found_from_samples_of_strain() {
    let stage = Stage::start_placed(|folder| sampling_board(folder, 2.0), "TIP").await;
    let is = async |condition: &str| stage.whisker(0).await.is_some_and(|whisker| whisker["condition"] == condition);
    until_within(LONG, "a whisker that is known", async || is("HEALTHY").await.then_some(())).await;
    let touched = stage.board_log().iter().filter(|line| line["log"] == "contact" && line["whisker"] == 0).count();
    let recorded = stage.recorded().await.iter().filter(|(whisker, _)| *whisker == 0).count();
    // A touch that begins within some 0.15 s of the end of another one has no baseline, and is left out.
    assert!(recorded <= touched && 3 * recorded >= touched, "{recorded} of {touched} touches");
    // It cuts whisker 0 to 60 mm.
    kill(Pid::from_raw(stage.board_pid().unwrap()), Signal::SIGUSR1).unwrap();
    let cut = until_within(LONG, "a whisker that is trimmed", async || {
        stage.whisker(0).await.filter(|whisker| whisker["condition"] == "TRIMMED")
    })
    .await;
    let length_mm = cut["length_mm"].as_f64().unwrap();
    assert!((57.0..63.0).contains(&length_mm), "{cut}");
    assert_ne!(stage.whisker(1).await.unwrap()["condition"], "TRIMMED");
}
