//! Attacks with HTTP connections: many, silent and slow ones.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use nix::sys::resource::{Resource, getrlimit, setrlimit};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};
use tokio::task::JoinSet;
use vibrissa_tests::wait::{PATIENCE, until_true};
use vibrissa_tests::web::{ask, open, try_get};

use crate::http_program::HttpProgram;

const IDLE: usize = 10_000;
const TRICKLING: usize = 1_000;
/// Limit of the memory of all these connections, bytes.
const GROWTH_MAX: u64 = 75_000_000;
/// Limit of the memory per idle connection, bytes. One page of a read buffer more would pass it.
const IDLE_MAX: u64 = 5000;
/// Limit of the memory per connection on which a request arrives, bytes.
const TRICKLING_MAX: u64 = 64 * 1024;

const OPEN: &str = "vibrissa_http_connections{listener=\"main\"}";

fn closed(reason: &str) -> String {
    format!("vibrissa_http_connections_closed_total{{listener=\"main\",reason=\"{reason}\"}}")
}

/// Raises this process's limit of open files to one per connection of the test.
fn raise_descriptors() {
    let (_, hard) = getrlimit(Resource::RLIMIT_NOFILE).unwrap();
    setrlimit(Resource::RLIMIT_NOFILE, hard, hard).unwrap();
    let needed = (IDLE + TRICKLING + 1000) as u64;
    assert!(hard >= needed, "this test needs {needed} open files, and the limit is {hard}: raise it (ulimit -Hn)");
}

async fn connect(to: SocketAddr) -> TcpStream {
    let deadline = Instant::now() + PATIENCE;
    loop {
        match TcpStream::connect(to).await {
            Ok(stream) => return stream,
            Err(problem) => assert!(Instant::now() < deadline, "no connection: {problem}"),
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

/// An open connection that has received an answer.
async fn served(to: SocketAddr) -> TcpStream {
    let mut stream = connect(to).await;
    stream.write_all(b"GET /livez HTTP/1.1\r\nHost: localhost\r\n\r\n").await.unwrap();
    let mut answer = Vec::new();
    while !answer.ends_with(b"alive\n") {
        assert!(stream.read_buf(&mut answer).await.unwrap() > 0, "{}", String::from_utf8_lossy(&answer));
    }
    stream
}

/// Sends an endless request head byte by byte, on a new connection whenever the server closes it.
async fn trickle(to: SocketAddr, stop: Arc<AtomicBool>) {
    while !stop.load(Ordering::Relaxed) {
        let Ok(mut stream) = TcpStream::connect(to).await else { continue };
        if stream.write_all(b"GET /livez HTTP/1.1\r\nHost: localhost\r\nX-Slow: ").await.is_err() {
            continue;
        }
        while !stop.load(Ordering::Relaxed) && stream.write_all(b"x").await.is_ok() {
            tokio::time::sleep(Duration::from_secs(1)).await;
        }
    }
}

/// Durations of honest requests in milliseconds, ascending, each over a connection of its own.
async fn honest(to: SocketAddr, requests: usize) -> Vec<f64> {
    let mut took = Vec::new();
    for number in 0..requests {
        let path = ["/livez", "/v1/whiskers", "/readyz"][number % 3];
        let begun = Instant::now();
        let (status, body) = try_get(to, path).await.unwrap();
        assert_eq!(status, 200, "{path}: {body}");
        took.push(begun.elapsed().as_secs_f64() * 1e3);
    }
    took.sort_by(f64::total_cmp);
    took
}

#[tokio::test(flavor = "multi_thread")]
async fn regress_ten_thousand_idle_and_a_thousand_trickling_connections_cost_little() {
    let _turn = crate::turn().await;
    raise_descriptors();
    let program =
        HttpProgram::start(&["--http-connections-max", "12000", "--http-connections-per-address-max", "12000"]);
    let http = program.http;
    until_true("ready", async || try_get(http, "/readyz").await.is_ok_and(|(status, _)| status == 200)).await;
    let usual = honest(http, 90).await;
    let before = program.resident_bytes();

    let mut kept = Vec::new();
    for _ in 0..IDLE / 2 {
        kept.push(served(http).await);
    }
    let with_kept = program.resident_bytes();
    let mut silent = Vec::new();
    for _ in 0..IDLE - kept.len() {
        silent.push(connect(http).await);
    }
    until_true("all silent connections", async || program.metric(OPEN).await >= IDLE as f64).await;
    let with_silent = program.resident_bytes();
    let stop = Arc::new(AtomicBool::new(false));
    let mut trickling = JoinSet::new();
    for _ in 0..TRICKLING {
        trickling.spawn(trickle(http, stop.clone()));
    }
    until_true("all connections", async || program.metric(OPEN).await >= (IDLE + TRICKLING) as f64).await;
    let took = honest(http, 90).await;
    let (median_ms, most_ms) = (took[took.len() / 2], took[took.len() - 1]);
    let after = program.resident_bytes();
    let each = |after: u64, before: u64, count: usize| after.saturating_sub(before) / count as u64;
    let costs = [
        each(with_kept, before, kept.len()),
        each(with_silent, with_kept, silent.len()),
        each(after, with_silent, TRICKLING),
    ];
    println!(
        "memory {before} B, then {after} B; a kept, a silent, a trickling connection: {costs:?} B; honest requests {median_ms:.1} ms \
         in the middle, {most_ms:.1} ms at the most"
    );
    assert!(after.saturating_sub(before) < GROWTH_MAX, "{before} B, then {after} B");
    let limits = [IDLE_MAX, IDLE_MAX, TRICKLING_MAX];
    assert!(
        costs.iter().zip(limits).all(|(cost, limit)| *cost <= limit),
        "{costs:?} B per connection, at most {limits:?}"
    );
    // A server that looked at each connection in turn would be far beyond it.
    assert!(median_ms < 50.0 * usual[usual.len() / 2].max(1.0), "{usual:?}, then {took:?}");
    stop.store(true, Ordering::Relaxed);
    trickling.abort_all();
}

/// Sends a request and repeats it once if the connection is closed, as clients do: during a flood the limit may close
/// it while this machine is busy.
async fn answered(to: SocketAddr) {
    for _ in 0..2 {
        if let Ok((status, body)) = try_get(to, "/v1/whiskers").await {
            assert_eq!(status, 200, "{body}");
            return;
        }
    }
    assert_eq!(try_get(to, "/v1/whiskers").await.unwrap().0, 200);
}

/// Beyond the limit the longest waiting connection is closed, but no honest client and no live stream.
#[tokio::test(flavor = "multi_thread")]
async fn regress_connections_without_end_leave_honest_requests_and_streams_alone() {
    let _turn = crate::turn().await;
    let program = HttpProgram::start(&["--http-connections-max", "200", "--http-connections-per-address-max", "100"]);
    let http = program.http;
    let (status, mut events) = open(http, "/v1/events", &[]).await.unwrap();
    assert_eq!(status, 200);
    let mut attackers: JoinSet<()> = JoinSet::new();
    for number in 0..300_u32 {
        // Three addresses reach both limits, per address and in total; each opens a new connection as soon as one is
        // closed.
        let from = SocketAddr::from(([127, 0, 0, 2 + (number % 3) as u8], 0));
        attackers.spawn(async move {
            loop {
                let socket = TcpSocket::new_v4().unwrap();
                socket.bind(from).unwrap();
                if let Ok(mut stream) = socket.connect(http).await {
                    // Waits until the server closes it.
                    let _ = stream.read_u8().await;
                }
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
        });
    }
    until_true("the limit", async || program.metric(&closed("DISPLACED")).await > 500.0).await;
    assert!(program.metric(OPEN).await <= 200.0);
    for _ in 0..60 {
        answered(http).await;
    }
    let quiet = tokio::time::timeout(Duration::from_millis(500), events.next()).await;
    assert!(!matches!(quiet, Ok(Ok(None) | Err(_))), "the stream has ended: {quiet:?}");
    // Monitoring has separate connections.
    assert_eq!(try_get(program.monitoring, "/livez").await.unwrap().0, 200);
    attackers.shutdown().await;
    let logged = program.logged();
    let notices = logged.lines().filter(|line| line.contains("too many HTTP connections")).count();
    assert!((1..=3).contains(&notices), "it must be logged, but not each time: {logged}");
}

#[tokio::test(flavor = "multi_thread")]
async fn regress_connections_never_take_the_last_file_descriptor() {
    let _turn = crate::turn().await;
    let program = HttpProgram::with_descriptors(100);
    let mut silent = Vec::new();
    for _ in 0..300 {
        silent.push(connect(program.http).await);
    }
    until_true("connections were closed", async || program.metric(&closed("DISPLACED")).await > 200.0).await;
    // Each request opens files of the database.
    for _ in 0..20 {
        assert_eq!(try_get(program.http, "/v1/whiskers").await.unwrap().0, 200);
    }
    assert!(program.logged().contains("fewer HTTP connections than http.connections_max"), "{}", program.logged());
    assert_eq!(program.metric("vibrissa_http_accept_errors_total{listener=\"main\"}").await, 0.0);
}

#[tokio::test(flavor = "multi_thread")]
async fn regress_connections_of_mqtt_never_take_the_last_file_descriptor_or_fill_the_log() {
    let _turn = crate::turn().await;
    let program = HttpProgram::with_descriptors(64);
    let mut silent = Vec::new();
    for _ in 0..300 {
        silent.push(connect(program.mqtt).await);
    }
    for _ in 0..20 {
        for path in ["/livez", "/metrics"] {
            // Without a free descriptor a connection is closed for the next one.
            let is_told = async || try_get(program.monitoring, path).await.is_ok_and(|(status, _)| status == 200);
            until_true(path, is_told).await;
        }
    }
    let log = program.logged();
    assert!(log.contains("too many connections, one was refused"), "{log}");
    assert!(log.lines().count() < 400, "{} lines", log.lines().count());
    drop(silent);
}

/// Reads the answer until the server closes the connection.
async fn until_closed(stream: &mut TcpStream) -> String {
    let mut answer = Vec::new();
    let read = tokio::time::timeout(Duration::from_secs(60), stream.read_to_end(&mut answer)).await;
    // A reset counts as closed, too.
    assert!(read.is_ok(), "still open after a minute");
    String::from_utf8_lossy(&answer).into_owned()
}

async fn slow_head(to: SocketAddr) -> Duration {
    let stream = connect(to).await;
    let (mut read, mut write) = stream.into_split();
    let begun = Instant::now();
    write.write_all(b"GET /livez HTTP/1.1\r\nX-Slow: ").await.unwrap();
    let trickling = tokio::spawn(async move {
        while write.write_all(b"x").await.is_ok() {
            tokio::time::sleep(Duration::from_millis(500)).await;
        }
    });
    let mut nothing = Vec::new();
    let _ = read.read_to_end(&mut nothing).await;
    trickling.abort();
    assert!(nothing.is_empty(), "{}", String::from_utf8_lossy(&nothing));
    begun.elapsed()
}

async fn slow_body(to: SocketAddr) -> String {
    let path = "/v1/fleets/f/robots/r/hold";
    let mut stream = connect(to).await;
    let head = format!(
        "POST {path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 1000\r\n\r\n{{"
    );
    stream.write_all(head.as_bytes()).await.unwrap();
    until_closed(&mut stream).await
}

/// Requests far more than buffers hold, and reads nothing for a while.
async fn slow_reader(to: SocketAddr) -> String {
    let mut stream = connect(to).await;
    let request = "GET /openapi.json HTTP/1.1\r\nHost: localhost\r\n\r\n";
    stream.write_all(request.repeat(100).as_bytes()).await.unwrap();
    // The server sends the first bytes and gives up before the rest is read.
    tokio::time::sleep(Duration::from_secs(22)).await;
    until_closed(&mut stream).await
}

#[tokio::test(flavor = "multi_thread")]
async fn regress_a_slow_head_a_slow_body_and_a_slow_reader_are_ended() {
    let program = HttpProgram::start(&[]);
    let (head, body, answer) =
        tokio::join!(slow_head(program.http), slow_body(program.http), slow_reader(program.http));
    assert!((Duration::from_secs(9)..Duration::from_secs(30)).contains(&head), "{head:?}");
    assert!(body.starts_with("HTTP/1.1 408 ") && body.contains("/problems/too-slow-body"), "{body}");
    assert!(answer.starts_with("HTTP/1.1 200 "));
    let whole = ask(program.http, "GET", "/openapi.json", &[]).await.unwrap().body.len();
    assert!(answer.len() < 100 * whole, "the whole answer was sent");
    for reason in ["SLOW_REQUEST", "SLOW_ANSWER"] {
        until_true(reason, async || program.metric(&closed(reason)).await == 1.0).await;
    }
    until_true("no connection is left", async || program.metric(OPEN).await == 0.0).await;
}

#[tokio::test]
async fn regress_a_head_larger_than_is_read_is_refused() {
    let program = HttpProgram::start(&[]);
    let long = "x".repeat(20_000);
    let answer = ask(program.http, "GET", "/livez", &[("X-Long", &long)]).await;
    // The server may close the connection before the request is complete.
    assert!(answer.is_err() || answer.is_ok_and(|answer| answer.status == 431));
    assert_eq!(try_get(program.http, "/livez").await.unwrap().0, 200);
}

/// Waits until this many answers of `/livez` have arrived.
async fn answers(stream: &mut TcpStream, count: usize) {
    let mut text = Vec::new();
    while String::from_utf8_lossy(&text).matches("alive\n").count() < count {
        let read = tokio::time::timeout(PATIENCE, stream.read_buf(&mut text)).await;
        assert!(matches!(read, Ok(Ok(1..))), "{read:?} after {}", String::from_utf8_lossy(&text));
    }
    assert_eq!(String::from_utf8_lossy(&text).matches("HTTP/1.1 200 OK").count(), count);
}

/// Between requests a connection releases its buffers, but not bytes that it has already read.
#[tokio::test]
async fn requests_that_come_before_others_are_answered_are_all_answered() {
    let program = HttpProgram::start(&[]);
    let mut stream = connect(program.http).await;
    let request = "GET /livez HTTP/1.1\r\nHost: localhost\r\n\r\n";
    let (begin, end) = request.split_at(20);
    stream.write_all(format!("{request}{request}{begin}").as_bytes()).await.unwrap();
    answers(&mut stream, 2).await;
    stream.write_all(end.as_bytes()).await.unwrap();
    answers(&mut stream, 1).await;
    // More than a buffer holds, split at arbitrary places.
    let many = request.repeat(1000);
    let (mut read, mut write) = stream.split();
    let sent = async {
        for piece in many.as_bytes().chunks(1013) {
            write.write_all(piece).await.unwrap();
        }
    };
    let answered = async {
        let mut text = Vec::new();
        while String::from_utf8_lossy(&text).matches("alive\n").count() < 1000 {
            let read = tokio::time::timeout(PATIENCE, read.read_buf(&mut text)).await;
            assert!(matches!(read, Ok(Ok(1..))), "{read:?} after {} bytes", text.len());
        }
    };
    tokio::join!(sent, answered);
    stream.write_all(request.as_bytes()).await.unwrap();
    answers(&mut stream, 1).await;
}

/// The rest of a body must not be parsed as the next request: behind a proxy it would run as another client's request.
#[tokio::test]
async fn what_is_left_of_a_body_is_no_request() {
    let program = HttpProgram::start(&[]);
    let smuggled = "GET /livez HTTP/1.1\r\nHost: localhost\r\n\r\n";
    for (method, path) in [("GET", "/v1/nothing"), ("POST", "/livez"), ("POST", "/v1/fleets/f/robots/r/hold")] {
        for length in [smuggled.len(), smuggled.len() + 1000] {
            let head = format!("{method} {path} HTTP/1.1\r\nHost: localhost\r\nContent-Length: {length}\r\n\r\n");
            let mut stream = connect(program.http).await;
            stream.write_all(head.as_bytes()).await.unwrap();
            let mut answer = Vec::new();
            while !answer.ends_with(b"}") {
                let read = tokio::time::timeout(PATIENCE, stream.read_buf(&mut answer)).await;
                assert!(matches!(read, Ok(Ok(1..))), "{method} {path}: {read:?}");
            }
            // The server may have closed the connection already.
            let _ = stream.write_all(smuggled.as_bytes()).await;
            let mut more = Vec::new();
            let _ = tokio::time::timeout(Duration::from_millis(300), stream.read_to_end(&mut more)).await;
            assert_eq!(String::from_utf8_lossy(&more), "", "{method} {path} with {length} bytes");
        }
    }
}
