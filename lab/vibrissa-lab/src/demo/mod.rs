//! The demonstration: broker, supervisor, database and a simulated fleet in one process, over real MQTT.

mod folder;
mod live;
mod picture;
mod report;
pub mod scenario;

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context;
use indicatif::{ProgressBar, ProgressStyle};
use tokio::time::Instant;
use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::Params;
use vibrissa_protocol::Name;
use vibrissa_simulator::Fleet;

use live::Incidents;
use scenario::{CONTACTS_PER_SECOND, INCIDENTS, What};
use vibrissa_store::DatabaseAddress;
use vibrissa_store::Store;
use vibrissa_supervisor::http::FurtherRoutes;
use vibrissa_supervisor::http::access::AccessOptions;
use vibrissa_supervisor::service::{BlackBoxOptions, HistoryOptions, LEASE_TIME_TO_LIVE, Service, ServiceOptions};

/// Longest time to wait for the expected events.
const PATIENCE: Duration = Duration::from_secs(50);
/// Seconds before and after an event whose messages a black box has: few, as everything else is in time-lapse.
const BLACK_BOX_SECONDS: u32 = 10;
/// Contacts of a compensator after which its error is known well: 12 bins of about 100.
const CONTACTS_TO_MEASURE: i64 = 1200;

/// Options of the demo.
#[derive(Debug, Clone)]
pub struct DemoOptions {
    /// Folder for the database and the chart.
    pub folder: PathBuf,
    /// Seed of the simulation.
    pub seed: u64,
    /// Port of the embedded broker.
    pub mqtt_port: u16,
    /// Address of the HTTP listener.
    pub http: SocketAddr,
    /// Whether the robots go on touching, for a person who lets incidents happen.
    pub serving: Serving,
    /// Whether to open the console in a browser, while the demo serves.
    pub opens_browser: bool,
}

/// Whether and when the demo serves a person.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Serving {
    /// The demo ends after its report.
    Never,
    /// After the report.
    AfterReport,
    /// At once, without the scripted part.
    AtOnce,
}

/// Runs the demo; true if all expected events happened.
///
/// # Errors
/// A part cannot be started, or a file cannot be written.
pub async fn run(options: &DemoOptions) -> anyhow::Result<bool> {
    let (database, picture_file) = folder::fresh(&options.folder)?;
    let incidents = Incidents::default();
    let routes = match options.serving {
        Serving::Never => FurtherRoutes::default(),
        Serving::AfterReport | Serving::AtOnce => live::routes(incidents.clone()),
    };
    let service_options = ServiceOptions {
        kafka: vibrissa_supervisor::service::KafkaOptions::default(),
        access: AccessOptions::default(),
        name: "demo".to_owned(),
        fleets: vec![Name::new(scenario::FLEET)?],
        database: DatabaseAddress::Sqlite(database.clone()),
        is_new_installation: true,
        lease_time_to_live: LEASE_TIME_TO_LIVE,
        metrics_per_whisker: false,
        limits: vibrissa_supervisor::service::LimitOptions::default(),
        history: HistoryOptions::default(),
        black_boxes: BlackBoxOptions { seconds: BLACK_BOX_SECONDS, ..BlackBoxOptions::default() },
        broker: None,
        mqtt_port: options.mqtt_port,
        mqtt_access: vibrissa_supervisor::broker::MqttAccess::Open,
        http: options.http.into(),
        webhooks: vibrissa_supervisor::webhooks::WebhookOptions::default(),
        traces: None,
        params: Params::nguyen_2021(Formulation::Published),
    };
    let service = Service::start_with(service_options, routes).await?;
    let broker = vibrissa_simulator::Broker::new(service.broker.host.clone(), service.broker.port);
    println!(
        "vibrissa-lab demo: two robots with ten whiskers, over MQTT on {broker:?}; HTTP on http://{}",
        service.http
    );
    let mut scenario = scenario::scenario(options.seed)?;
    if options.serving == Serving::AtOnce {
        scenario.robots.iter_mut().for_each(|robot| robot.events.clear());
        let fleet = Fleet::start(&scenario, &broker)?;
        println!(
            "The supervisor learns the whiskers from {CONTACTS_PER_SECOND} contacts of each a second (time-lapse)."
        );
        live::learn(&service.store).await?;
        live::run(&service, &fleet, &incidents, options.opens_browser).await?;
        fleet.stop().await;
        service.stop().await;
        return Ok(true);
    }
    println!(
        "Each whisker has {CONTACTS_PER_SECOND} contacts a second (time-lapse). Four are cut, one erodes, one is cut \
         too short. crawler-2 multiplies its readings, crawler-1 has air alone.\n"
    );
    let fleet = Fleet::start(&scenario, &broker)?;
    watch(&service.store).await?;
    let settled = settle(&fleet, &service.store).await?;
    let outcome = report::report(&service.store, &fleet, settled).await?;
    print!("{}", outcome.text);

    let drawn = picture::draw(&service.store, &picture_file).await;
    drawn.with_context(|| format!("drawing {}", picture_file.display()))?;
    println!("\nDatabase: {}\nChart:    {}", database.display(), picture_file.display());
    if options.serving == Serving::Never {
        println!("Next: the same with a console, where you break whiskers yourself: demo --live --open");
    } else {
        live::run(&service, &fleet, &incidents, options.opens_browser).await?;
    }
    fleet.stop().await;
    service.stop().await;
    Ok(outcome.passed)
}

/// Prints what the supervisor does until it has done everything, or [`PATIENCE`] is over.
async fn watch(store: &Store) -> anyhow::Result<()> {
    let compensations = INCIDENTS.iter().filter(|one| matches!(one.what, What::Trim { .. })).count();
    let bar = ProgressBar::new(compensations as u64 * CONTACTS_TO_MEASURE as u64);
    bar.set_style(ProgressStyle::with_template("{elapsed:>4} {bar:40} {msg}")?);
    let begun = Instant::now();
    let mut printed = 0;
    while begun.elapsed() < PATIENCE {
        tokio::time::sleep(Duration::from_millis(250)).await;
        let lines = report::story(store).await?;
        for line in lines.iter().skip(printed) {
            let line = format!("{:5.1} s  {line}", begun.elapsed().as_secs_f64());
            if bar.is_hidden() { println!("{line}") } else { bar.println(line) }
        }
        printed = lines.len();
        let measured: Vec<i64> = store.measured_contacts().await?;
        let done: i64 = measured.iter().map(|contacts| (*contacts).min(CONTACTS_TO_MEASURE)).sum();
        bar.set_position(done as u64);
        bar.set_message(format!("{} contacts recorded", store.contact_count().await?));
        let all_measured =
            measured.iter().filter(|&&contacts| contacts >= CONTACTS_TO_MEASURE).count() >= compensations;
        let answered = store.setpoint_states().await?.iter().all(|(state, _)| state == "APPLIED");
        if all_measured && answered && report::is_all_found(store).await? {
            break;
        }
    }
    bar.finish_and_clear();
    Ok(())
}

/// Stops the contacts and waits until every contact is receipted; true if that succeeded.
async fn settle(fleet: &Fleet, store: &Store) -> anyhow::Result<bool> {
    fleet.rest();
    let made = fleet.contacts_made();
    let deadline = Instant::now() + Duration::from_secs(5);
    while Instant::now() < deadline {
        let kept: usize = fleet.robots().iter().map(|robot| robot.with(|robot| robot.messages_kept())).sum();
        if kept == 0 && store.contact_count().await? as u64 == made {
            return Ok(true);
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    Ok(false)
}
