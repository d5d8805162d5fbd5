//! Network connections: latency, cuts, resets, ends.

use std::io::ErrorKind;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::{Instant, sleep};

use super::*;
use crate::broker::{Route, Way, Wire, WireEnd};

const MS_30: Duration = Duration::from_millis(30);
const MS_70: Duration = Duration::from_millis(70);

fn wire() -> (WireEnd, WireEnd, Wire) {
    Wire::pair([MS_30, MS_70])
}

async fn read(end: &mut WireEnd) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(1024);
    end.read_buf(&mut bytes).await.unwrap();
    bytes
}

#[tokio::test(start_paused = true)]
async fn bytes_arrive_in_order_after_the_latency_of_their_direction() {
    let (mut client, mut broker, _wire) = wire();
    let begun = Instant::now();
    client.write_all(b"there").await.unwrap();
    assert_eq!(read(&mut broker).await, b"there");
    assert_eq!(begun.elapsed(), MS_30);
    broker.write_all(b"and ").await.unwrap();
    broker.write_all(b"back").await.unwrap();
    let mut bytes = [0; 8];
    client.read_exact(&mut bytes).await.unwrap();
    assert_eq!((&bytes, begun.elapsed()), (b"and back", MS_30 + MS_70));
}

#[tokio::test(start_paused = true)]
async fn a_lower_latency_does_not_let_bytes_overtake() {
    let (mut client, mut broker, wire) = wire();
    client.write_all(b"1").await.unwrap();
    wire.set_latency(Way::ToBroker, Duration::ZERO);
    client.write_all(b"2").await.unwrap();
    let begun = Instant::now();
    let mut bytes = [0; 2];
    broker.read_exact(&mut bytes).await.unwrap();
    assert_eq!((&bytes, begun.elapsed()), (b"12", MS_30));
}

#[tokio::test(start_paused = true)]
async fn a_cut_holds_bytes_of_one_direction_until_it_heals() {
    let (mut client, mut broker, wire) = wire();
    wire.set_cut(Way::ToBroker, true);
    client.write_all(b"held").await.unwrap();
    broker.write_all(b"passes").await.unwrap();
    assert_eq!(read(&mut client).await, b"passes");
    assert!(timeout(LONG, read(&mut broker)).await.is_err());
    let (arrived, ()) = tokio::join!(read(&mut broker), async { wire.set_cut(Way::ToBroker, false) });
    assert_eq!(arrived, b"held");
}

#[tokio::test(start_paused = true)]
async fn an_end_behind_a_cut_is_noticed_after_the_healing() {
    let (mut client, broker, wire) = wire();
    wire.set_cut(Way::ToClient, true);
    drop(broker);
    client.write_all(b"into the void").await.unwrap();
    assert!(timeout(LONG, read(&mut client)).await.is_err());
    wire.set_cut(Way::ToClient, false);
    assert_eq!(read(&mut client).await, b"");
    assert_eq!(client.write_all(b"more").await.unwrap_err().kind(), ErrorKind::BrokenPipe);
}

#[tokio::test(start_paused = true)]
async fn a_writer_waits_while_the_window_is_full() {
    let (mut client, mut broker, _wire) = wire();
    let large = vec![7; 300 * 1024];
    assert!(timeout(LONG, client.write_all(&large)).await.is_err());
    let mut bytes = vec![0; 256 * 1024];
    let more = b"more";
    let (_, written) = tokio::join!(broker.read_exact(&mut bytes), client.write_all(more));
    written.unwrap();
    assert_eq!(read(&mut broker).await, more);
}

#[tokio::test(start_paused = true)]
async fn a_reset_fails_both_ends_and_a_close_ends_them_after_their_bytes() {
    let (mut client, mut broker, wire) = wire();
    client.write_all(b"lost").await.unwrap();
    wire.reset();
    for end in [&mut client, &mut broker] {
        assert_eq!(end.read_u8().await.unwrap_err().kind(), ErrorKind::ConnectionReset);
        assert_eq!(end.write_all(b"x").await.unwrap_err().kind(), ErrorKind::ConnectionReset);
    }
    let (mut client, mut broker, wire) = self::wire();
    client.write_all(b"last").await.unwrap();
    wire.close();
    assert!(client.write_all(b"x").await.is_err() && read(&mut client).await.is_empty());
    assert_eq!((read(&mut broker).await, read(&mut broker).await), (b"last".to_vec(), Vec::new()));
    assert!(wire.is_open());
    drop((client, broker));
    assert!(!wire.is_open());
}

#[tokio::test(start_paused = true)]
async fn a_route_connects_after_two_latencies_and_not_through_a_cut() {
    let broker = broker();
    let route = Route::new(broker.clone(), MS_30);
    let begun = Instant::now();
    drop(route.connect().await.unwrap());
    assert_eq!(begun.elapsed(), 2 * MS_30);
    route.set_cut(Way::ToClient, true);
    let healing = async {
        sleep(LONG).await;
        route.set_cut(Way::ToClient, false);
    };
    let (end, ()) = tokio::join!(route.connect(), healing);
    assert!(end.is_ok());
    assert_eq!(begun.elapsed(), LONG + 4 * MS_30);
    broker.set_accepting(false);
    assert_eq!(route.connect().await.unwrap_err().kind(), ErrorKind::ConnectionRefused);
}
