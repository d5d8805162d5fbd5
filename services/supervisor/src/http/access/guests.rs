//! Limits of requests by people and programs that are not identified: by the address of the client.
//!
//! A flood from one address leaves the others alone. The limits never concern a request with a right credential, once
//! this supervisor has read its hash.

use std::hash::{BuildHasher as _, RandomState};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::num::NonZeroU32;

use axum::extract::{ConnectInfo, Request, State};
use axum::http::request::Parts;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use governor::{DefaultKeyedRateLimiter, Quota, RateLimiter};

use super::Access;
use crate::http::client_address::{TrustedProxies, counted};
use crate::http::problem::{Kind, Problem};

/// Average rate of requests with a wrong credential from one address, in requests per second.
const WRONG_PER_S: NonZeroU32 = NonZeroU32::new(200).unwrap();
/// Burst of them, in requests.
const WRONG_BURST: NonZeroU32 = NonZeroU32::new(1000).unwrap();
/// Average rate of requests below `/auth` from one address, in requests per second. Many people can share an address.
const SIGN_INS_PER_S: NonZeroU32 = NonZeroU32::new(20).unwrap();
/// Burst of them, in requests.
const SIGN_INS_BURST: NonZeroU32 = NonZeroU32::new(200).unwrap();

/// Counts requests by address. An address has one of 65,536 slots, so that the memory stays small whatever is sent from
/// however many addresses. Nobody knows which addresses share a slot.
#[derive(Debug)]
pub(super) struct Guests {
    slots: RandomState,
    wrong: DefaultKeyedRateLimiter<u16>,
    /// Credentials for which the database is to be read.
    unknown: DefaultKeyedRateLimiter<u16>,
    sign_ins: DefaultKeyedRateLimiter<u16>,
}

impl Default for Guests {
    fn default() -> Self {
        let keyed = |rate, burst| RateLimiter::keyed(Quota::per_second(rate).allow_burst(burst));
        let [wrong, unknown] = std::array::from_fn(|_| keyed(WRONG_PER_S, WRONG_BURST));
        Self { slots: RandomState::new(), wrong, unknown, sign_ins: keyed(SIGN_INS_PER_S, SIGN_INS_BURST) }
    }
}

impl Guests {
    /// Counts a request with a wrong credential.
    pub(super) fn wrong(&self, client: IpAddr) -> Result<(), Problem> {
        self.count(&self.wrong, client, "requests with a wrong credential")
    }

    /// Counts a request with a credential for which the database is to be read. Beyond the limit it is not read.
    pub(super) fn unknown(&self, client: IpAddr) -> Result<(), Problem> {
        self.count(&self.unknown, client, "requests with an unknown credential")
    }

    /// Counts a request below `/auth`.
    pub(super) fn sign_in(&self, client: IpAddr) -> Result<(), Problem> {
        self.count(&self.sign_ins, client, "requests to sign in")
    }

    fn count(&self, limiter: &DefaultKeyedRateLimiter<u16>, client: IpAddr, what: &str) -> Result<(), Problem> {
        let slot = self.slots.hash_one(counted(client)) as u16;
        limiter.check_key(&slot).map_err(|_| {
            let detail = format!("too many {what} from this address: wait a second, then send fewer");
            Problem::new(Kind::TooManyRequests, detail)
        })
    }
}

/// Address of a request's client.
pub(super) fn client(proxies: &TrustedProxies, request: &Parts) -> IpAddr {
    let peer = request.extensions.get::<ConnectInfo<SocketAddr>>();
    let peer = peer.map_or(Ipv4Addr::UNSPECIFIED.into(), |ConnectInfo(peer)| peer.ip());
    proxies.client(peer, &request.headers)
}

/// Limits the requests of the routes below `/auth`, which are open to everyone.
pub(in crate::http) async fn limit_sign_ins(State(access): State<Access>, request: Request, next: Next) -> Response {
    let (parts, body) = request.into_parts();
    match access.guests.sign_in(client(&access.proxies, &parts)) {
        Ok(()) => next.run(Request::from_parts(parts, body)).await,
        Err(problem) => problem.into_response(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How many of so many requests from an address are let through.
    fn passed(count: impl Fn(IpAddr) -> Result<(), Problem>, address: &str, requests: u32) -> u32 {
        (0..requests).map(|_| u32::from(count(address.parse().unwrap()).is_ok())).sum()
    }

    #[test]
    fn regress_a_flood_from_one_address_leaves_the_others_alone() {
        let guests = Guests::default();
        for count in [&(|client| guests.sign_in(client)) as &dyn Fn(IpAddr) -> _, &|client| guests.wrong(client)] {
            for flood in ["192.0.2.1", "2001:db8::1"] {
                assert!(passed(count, flood, 30_000) < 10_000, "{flood}");
            }
            // A slot is shared by chance with a probability of 1 : 32,768 for each of these.
            let people = ["192.0.2.2", "10.0.0.1", "2001:db8:0:1::1", "::1"];
            let let_in: u32 = people.iter().map(|person| passed(count, person, 20)).sum();
            assert_eq!(let_in, 80);
            assert!(passed(count, "2001:db8::ffff", 100) < 50, "the same network");
        }
    }

    #[test]
    fn attack_the_memory_for_millions_of_addresses_is_small() {
        let guests = Guests::default();
        for number in 0..200_000_u32 {
            let _ = guests.wrong(IpAddr::V4(number.into()));
        }
        assert!(guests.wrong.len() <= 65_536, "{}", guests.wrong.len());
    }
}
