//! A service with a robot, and a browser that shows its console.

use std::path::PathBuf;
use std::time::Duration;

use serde_json::Value;
use sqlx::ConnectOptions as _;
use sqlx::sqlite::SqliteConnectOptions;
use tempfile::TempDir;
use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::Params;
use vibrissa_protocol::{ArrayType, Name};
use vibrissa_store::DatabaseAddress;
use vibrissa_store::secret::Secret;
use vibrissa_supervisor::http::HttpOptions;
use vibrissa_supervisor::http::access::AccessOptions;
use vibrissa_supervisor::service::{LEASE_TIME_TO_LIVE, Service, ServiceOptions};
use vibrissa_supervisor::webhooks::{Pace, WebhookOptions};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::{PATIENCE, until_true};
use vibrissa_tests::web::try_get;

use crate::browser::Browser;

/// Contacts until a whisker counts as learned; few, so that tests are fast.
pub(crate) const LEARNED: usize = 60;

/// Pauses between attempts of webhooks that a test can wait for.
const FAST: Pace = Pace {
    first: Duration::from_millis(20),
    longest: Duration::from_millis(100),
    attempts_max: 2,
    age_max: Duration::from_secs(86_400),
};

/// Largest number of rounds of contacts until a cut is detected.
const ROUNDS_MAX: usize = 30;

/// The programs of a test.
pub(crate) struct Stage {
    pub(crate) service: Service,
    pub(crate) robot: HandRobot,
    pub(crate) browser: Browser,
    folder: TempDir,
}

impl Stage {
    /// Starts a service that requires no token.
    pub(crate) async fn start() -> Self {
        Self::to(AccessOptions::default(), |_| ()).await
    }

    /// Starts a service that knows no robot yet.
    pub(crate) async fn without_robots() -> Self {
        Self::unborn(&["f"], ([127, 0, 0, 1], 0).into(), AccessOptions::default(), |_| ()).await
    }

    /// Starts a service of the fleets `f` and `g`. Fleet `g` has the robot that is returned.
    pub(crate) async fn of_two_fleets() -> (Self, HandRobot) {
        let http = ([127, 0, 0, 1], 0).into();
        let stage = Self::of(&["f", "g"], http, AccessOptions::default(), |_| ()).await;
        let other = array(ArrayType::Type1, &[70.0, 68.0]);
        let robot = HandRobot::born_in("g", stage.service.broker.port, "other", other).await;
        (stage, robot)
    }

    /// Starts a service that requires a token.
    pub(crate) async fn closed() -> Self {
        let token = Some(Secret::new("nobody-in-this-test-has-this-token"));
        Self::to(AccessOptions { token, oidc: None }, |_| ()).await
    }

    /// Starts a service with other parameters of the core.
    pub(crate) async fn with(change: impl FnOnce(&mut Params)) -> Self {
        Self::to(AccessOptions::default(), change).await
    }

    /// Starts a service on this port with these credentials.
    pub(crate) async fn at(port: u16, access: AccessOptions) -> Self {
        Self::on(([127, 0, 0, 1], port).into(), access, |_| ()).await
    }

    async fn to(access: AccessOptions, change: impl FnOnce(&mut Params)) -> Self {
        Self::on(([127, 0, 0, 1], 0).into(), access, change).await
    }

    /// Tokens of the only session, as the database has them.
    pub(crate) async fn sealed(&self) -> String {
        let file = SqliteConnectOptions::new().filename(self.folder.path().join("vibrissa.sqlite3"));
        let mut link = file.connect().await.unwrap();
        sqlx::query_scalar("SELECT hex(sealed) FROM console_sessions").fetch_one(&mut link).await.unwrap()
    }

    /// Runs statements on the database.
    pub(crate) async fn run(&self, sql: &str) {
        let file = SqliteConnectOptions::new().filename(self.folder.path().join("vibrissa.sqlite3"));
        let mut link = file.busy_timeout(PATIENCE).connect().await.unwrap();
        sqlx::raw_sql(sqlx::AssertSqlSafe(sql)).execute(&mut link).await.unwrap();
    }

    /// Writes robots `more-1`, `more-2` .. of fleet `f` into the database, without any that connects. They are in ten halls by
    /// their label, and no state is stored that a supervisor could load.
    pub(crate) async fn crowd(&self, robots: u32) {
        let file = SqliteConnectOptions::new().filename(self.folder.path().join("vibrissa.sqlite3"));
        let mut link = file.busy_timeout(PATIENCE).connect().await.unwrap();
        for (into, values) in [
            (
                "robots(robot_id, fleet, robot, connection, model, updated_us, labels)",
                "1000 + i, 'f', 'more-' || i, 'ONLINE', 'm', 1, 'hall=' || (i % 10)",
            ),
            ("arrays(array_id, robot_id, \"array\", array_type, whiskers)", "1000 + i, 1000 + i, 'left', 'TYPE_1', 1"),
        ] {
            let numbers = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < $1)";
            let sql = format!("{numbers} INSERT INTO {into} SELECT {values} FROM n");
            sqlx::query(sqlx::AssertSqlSafe(sql)).bind(robots).execute(&mut link).await.unwrap();
        }
    }

    async fn on(http: HttpOptions, access: AccessOptions, change: impl FnOnce(&mut Params)) -> Self {
        Self::of(&["f"], http, access, change).await
    }

    /// Starts robot `r` of fleet `f`, whose array `left` has three whiskers with learned baselines.
    async fn of(fleets: &[&str], http: HttpOptions, access: AccessOptions, change: impl FnOnce(&mut Params)) -> Self {
        let mut stage = Self::unborn(fleets, http, access, change).await;
        stage.robot.birth().await;
        stage.robot.settle().await;
        for whisker in 0..3 {
            stage.robot.touch(whisker, LEARNED + 20).await;
        }
        stage.robot.receipted().await;
        stage
    }

    /// Starts a service, with robot `r` connected to its broker and silent.
    async fn unborn(
        fleets: &[&str],
        http: HttpOptions,
        access: AccessOptions,
        change: impl FnOnce(&mut Params),
    ) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let fleets: Vec<Name> = fleets.iter().map(|fleet| Name::new(fleet).unwrap()).collect();
        let mut params = Params::nguyen_2021(Formulation::Published);
        params.detection.cold_start_contacts = LEARNED as u32;
        change(&mut params);
        let service = Service::start(ServiceOptions {
            kafka: vibrissa_supervisor::service::KafkaOptions::default(),
            access,
            name: "s".to_owned(),
            fleets: fleets.clone(),
            database: DatabaseAddress::Sqlite(folder.path().join("vibrissa.sqlite3")),
            is_new_installation: true,
            lease_time_to_live: LEASE_TIME_TO_LIVE,
            limits: vibrissa_supervisor::service::LimitOptions::default(),
            history: vibrissa_supervisor::service::HistoryOptions::default(),
            black_boxes: vibrissa_supervisor::service::BlackBoxOptions::default(),
            metrics_per_whisker: false,
            broker: None,
            mqtt_port: 0,
            mqtt_access: vibrissa_supervisor::broker::MqttAccess::Open,
            http,
            webhooks: WebhookOptions { allowed_hosts: vec!["127.0.0.1".to_owned()], pace: FAST, mail: None },
            traces: None,
            params,
        })
        .await
        .unwrap();
        for fleet in fleets {
            let connected = service.metrics.of_fleet(&fleet).broker_connected;
            until_true("the connection to the broker", async || connected.get() == 1).await;
        }
        let sheet = array(ArrayType::Type1, &[70.0, 68.0, 65.0]);
        let robot = HandRobot::connect(service.broker.port, "r", sheet).await;
        Self { service, robot, browser: Browser::start().await, folder }
    }

    /// Cuts whisker 0 to 65 mm and sends contacts of all whiskers until the cut is detected. Contacts of the others
    /// show that the array itself has not changed.
    pub(crate) async fn cut(&mut self) {
        self.robot.cut(0, 65.0);
        for _ in 0..ROUNDS_MAX {
            for whisker in 0..3 {
                self.robot.touch(whisker, 20).await;
            }
            self.robot.receipted().await;
            let (status, trims) = try_get(self.service.http, "/v1/trims").await.unwrap();
            assert_eq!(status, 200, "{trims}");
            if trims.contains("trim_id") {
                return;
            }
        }
        panic!("the cut was not found");
    }

    /// URL of an address in the console.
    pub(crate) fn url(&self, hash: &str) -> String {
        format!("http://127.0.0.1:{}/{hash}", self.service.http.port())
    }

    /// Opens an address of the console.
    pub(crate) async fn open(&mut self, hash: &str) {
        let url = self.url(hash);
        self.browser.open(&url).await;
    }

    /// Name and address of every page, for the state after the cut of whisker 0 and its decision.
    pub(crate) async fn pages(&self) -> Vec<(&'static str, String)> {
        let (_, decisions) = try_get(self.service.http, "/v1/compensations").await.unwrap();
        let decisions: Value = serde_json::from_str(&decisions).unwrap();
        let decision = &decisions["items"][0]["compensation_id"];
        let pages = [
            ("fleets", "fleets"),
            ("fleet", "fleets/f"),
            ("robot", "fleets/f/robots/r"),
            ("whisker", "fleets/f/robots/r/arrays/left/whiskers/0"),
            ("whisker-charts", "fleets/f/robots/r/arrays/left/whiskers/0?tab=charts"),
            ("whisker-decisions", "fleets/f/robots/r/arrays/left/whiskers/0?tab=decisions"),
            ("whisker-history", "fleets/f/robots/r/arrays/left/whiskers/0?tab=history"),
            ("whiskers", "whiskers"),
            ("compensations", "compensations"),
            ("compensation", &format!("compensations/{decision}")),
            ("alarms", "alarms"),
            ("alarm-statistics", "alarm-statistics"),
            ("timeline", "timeline"),
            ("what-if", "what-if?fleet=f&robot=r&array=left&whisker=0&length_mm=62"),
            ("calibrations", "calibrations"),
            ("trims", "trims"),
            ("setpoints", "setpoints"),
            ("bulk", "bulk"),
            ("rollouts", "rollouts"),
            ("policy", "policy"),
            ("webhooks", "webhooks"),
            ("audit", "audit"),
            ("api", "api"),
            ("operation", "api/list_compensations"),
            ("nowhere", "no/such/page"),
        ];
        pages.into_iter().map(|(name, address)| (name, format!("#/{address}"))).collect()
    }

    /// Writes a picture of the whole page into the folder named by `VIBRISSA_PICTURES`, if that is set.
    pub(crate) async fn picture(&mut self, name: &str) {
        if let Some(folder) = std::env::var_os("VIBRISSA_PICTURES") {
            self.browser.picture(&PathBuf::from(folder).join(format!("{name}.png"))).await;
        }
    }

    /// Asserts that the page had no errors and sent requests only to the service.
    pub(crate) fn is_clean(&self) {
        assert_eq!(self.browser.problems(), Vec::<String>::new());
        let own = self.url("");
        let strange = |url: &String| !(url.starts_with(&own) || url.starts_with("about:") || url.starts_with("data:"));
        let strange: Vec<String> = self.browser.asked().into_iter().filter(strange).collect();
        assert_eq!(strange, Vec::<String>::new());
    }

    pub(crate) async fn stop(self) {
        drop(self.browser);
        self.service.stop().await;
    }
}
