//! Writes boxes to the database, one after the other.

use tokio::sync::mpsc;
use tokio::time::{Duration, Instant, sleep};
use tracing::warn;
use vibrissa_edge::full_name::FullName;
use vibrissa_host::task;
use vibrissa_store::black_boxes::NewBlackBox;
use vibrissa_store::{StoreError, Writer};

use super::job::{BoxToWrite, Job};
use super::lines;

/// How long a box is tried again while the database is unreachable. Later boxes wait meanwhile.
const PATIENCE: Duration = Duration::from_secs(30);
/// Pause between two attempts.
const PAUSE: Duration = Duration::from_secs(1);

/// Writes boxes until no more can come.
pub(super) async fn run(mut jobs: mpsc::Receiver<Job>, mut writer: Writer) {
    while let Some(job) = jobs.recv().await {
        match job {
            Job::Write(one) => write(*one, &mut writer).await,
            // An error means that nobody waits any more.
            Job::Flush(done) => drop(done.send(())),
        }
    }
}

async fn write(one: BoxToWrite, writer: &mut Writer) {
    let (lease, lost, name) = (one.lease.clone(), one.lost.clone(), one.robot.clone());
    let robot = FullName::robot(lease.fleet().as_str(), name.as_str());
    let row = match task::blocking(move || row(&one)).await {
        Ok(Ok(row)) => row,
        Ok(Err(problem)) => {
            lost.inc();
            return warn!(%robot, %problem, "cannot compress a black box, it is lost");
        }
        Err(problem) => {
            lost.inc();
            return warn!(%robot, %problem, "cannot make the lines of a black box, it is lost");
        }
    };
    let deadline = Instant::now() + PATIENCE;
    loop {
        match writer.write_black_box(&lease, &row).await {
            Ok(()) => return,
            // The new owner of the fleet has marked it.
            Err(StoreError::LeaseLost { .. }) => return,
            Err(problem) if Instant::now() >= deadline || problem.rejection().is_some() => {
                lost.inc();
                return warn!(%robot, %problem, "cannot write a black box, it is lost");
            }
            Err(_) => sleep(PAUSE).await,
        }
    }
}

fn row(one: &BoxToWrite) -> std::io::Result<NewBlackBox> {
    let lines = lines::of(one)?;
    Ok(NewBlackBox {
        robot_id: one.robot_id,
        whisker_id: one.whisker_id,
        cause: one.cause,
        event_us: one.event.0 as i64,
        began_us: one.from.0 as i64,
        ends_us: one.ends.0 as i64,
        last_us: lines.last.0 as i64,
        state: one.state,
        messages: lines.messages,
        left_out: one.left_out as i64,
        has_state: lines.has_state,
        bytes: lines.bytes as i64,
        body: lines.body,
    })
}
