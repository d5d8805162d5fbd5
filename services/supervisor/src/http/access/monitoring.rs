//! Access to `/readyz` and `/metrics` on the main listener, which also serves everything else.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::extract::{Request, State};
use axum::http::header;
use axum::http::request::Parts;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use tokio::time::{Instant, timeout};

use super::origin::require_direct;
use super::{Access, Caller, Credential, Gate, Scope};
use crate::http::problem::{Kind, Problem};
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::Store;

/// Longest look-up of a caller: `/readyz` answers within 300 ms, also while the database hangs. Longer than a new token has to
/// wait for others (`known.rs`).
const LOOK_UP_MAX: Duration = Duration::from_millis(250);
/// Time for which a caller who was identified is not looked up again.
const FRESH: Duration = Duration::from_secs(5);
/// Limit of the remembered callers.
const CALLERS_MAX: usize = 256;

/// Lets a request pass that comes from this machine to a loopback listener, or has a token for all fleets.
pub(in crate::http) async fn check(State(gate): State<Gate>, request: Request, next: Next) -> Response {
    let (parts, body) = request.into_parts();
    match admit(&gate.access, &gate.store, &parts).await {
        Ok(()) => next.run(Request::from_parts(parts, body)).await,
        Err(problem) => problem.into_response(),
    }
}

async fn admit(access: &Access, store: &Store, request: &Parts) -> Result<(), Problem> {
    let is_local = access.is_loopback && require_direct(request.version, &request.headers).is_ok();
    if is_local && !request.headers.contains_key(header::AUTHORIZATION) {
        return Ok(());
    }
    let identified = async {
        let credential = access.credential(request)?;
        access.monitors.identified(&credential, access.identify_request(store, request, &credential)).await
    };
    let caller = match identified.await {
        Ok(caller) => caller,
        Err(problem) => return Err(access.refused(request, problem)),
    };
    access.limit(&caller.actor)?;
    if caller.scope == Scope::All {
        return Ok(());
    }
    Err(Problem::new(
        Kind::Forbidden,
        "this covers every fleet: use a token for all fleets (vibrissa token create --role viewer --all-fleets), or \
         the listener http.monitoring_listen",
    ))
}

/// Callers of these routes. A caller who was identified before is let in while the database does not answer: that is when its
/// monitoring matters most. Clones share them.
#[derive(Debug, Clone, Default)]
pub(super) struct Monitors(Arc<Mutex<HashMap<blake3::Hash, (Caller, Instant)>>>);

impl Monitors {
    /// The caller of a credential, after at most [`LOOK_UP_MAX`].
    async fn identified(
        &self,
        credential: &Credential,
        look_up: impl Future<Output = Result<Caller, Problem>>,
    ) -> Result<Caller, Problem> {
        let key = match credential {
            Credential::Nothing => return look_up.await,
            Credential::Bearer(secret) | Credential::Session(secret) => blake3::hash(secret.reveal().as_bytes()),
        };
        let known = self.callers().get(&key).cloned();
        let known = known.filter(|(caller, _)| caller.expires_us.is_none_or(|until| until > wall_clock().0 as i64));
        if let Some((caller, _)) = known.as_ref().filter(|(_, identified)| identified.elapsed() < FRESH) {
            return Ok(caller.clone());
        }
        let Ok(found) = timeout(LOOK_UP_MAX, look_up).await else {
            let hangs = "the token is not known here, and cannot be checked now: nothing answers in time";
            return known.map(|(caller, _)| caller).ok_or_else(|| Problem::new(Kind::Unauthenticated, hangs));
        };
        match found {
            Ok(caller) => {
                let mut callers = self.callers();
                if callers.len() >= CALLERS_MAX {
                    callers.retain(|_, (_, identified)| identified.elapsed() < FRESH);
                }
                if callers.len() < CALLERS_MAX {
                    callers.insert(key, (caller.clone(), Instant::now()));
                }
                Ok(caller)
            }
            Err(problem) if problem.kind == Kind::Unavailable => known.map(|(caller, _)| caller).ok_or(problem),
            Err(problem) => {
                self.callers().remove(&key);
                Err(problem)
            }
        }
    }

    fn callers(&self) -> MutexGuard<'_, HashMap<blake3::Hash, (Caller, Instant)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use std::future::{pending, ready};

    use super::*;
    use vibrissa_store::secret::Secret;

    fn token(text: &str) -> Credential {
        Credential::Bearer(Secret::new(text))
    }

    fn refused() -> Problem {
        Problem::new(Kind::Unauthenticated, "the token is unknown")
    }

    #[tokio::test]
    async fn regress_a_database_that_hangs_delays_no_monitor() {
        let monitors = Monitors::default();
        let known = monitors.identified(&token("known"), ready(Ok(Caller::local()))).await;
        assert_eq!(known.unwrap(), Caller::local());
        assert_eq!(monitors.identified(&token("known"), pending()).await.unwrap(), Caller::local());
        monitors.age();
        assert_eq!(monitors.identified(&token("known"), pending()).await.unwrap(), Caller::local());
        let unknown = monitors.identified(&token("unknown"), pending()).await;
        assert_eq!(unknown.unwrap_err().kind, Kind::Unauthenticated);
    }

    #[tokio::test]
    async fn a_revoked_token_and_an_expired_one_are_refused() {
        let monitors = Monitors::default();
        let until = |expires_us| Caller { expires_us: Some(expires_us), ..Caller::local() };
        let past = until(wall_clock().0 as i64 - 1);
        assert!(monitors.identified(&token("expires"), ready(Ok(past))).await.is_ok());
        assert!(monitors.identified(&token("expires"), ready(Err(refused()))).await.is_err());
        assert!(monitors.identified(&token("revoked"), ready(Ok(Caller::local()))).await.is_ok());
        monitors.age();
        assert!(monitors.identified(&token("revoked"), ready(Err(refused()))).await.is_err());
        assert!(monitors.identified(&token("revoked"), pending()).await.is_err(), "it is forgotten");
    }

    #[tokio::test]
    async fn attack_many_tokens_take_little_memory() {
        let monitors = Monitors::default();
        for number in 0..2 * CALLERS_MAX {
            let one = token(&number.to_string());
            assert!(monitors.identified(&one, ready(Ok(Caller::local()))).await.is_ok());
        }
        assert_eq!(monitors.callers().len(), CALLERS_MAX);
    }

    impl Monitors {
        /// Lets the time pass for which callers are not looked up again.
        fn age(&self) {
            self.callers()
                .values_mut()
                .for_each(|(_, identified)| *identified = Instant::now().checked_sub(FRESH).unwrap());
        }
    }
}
