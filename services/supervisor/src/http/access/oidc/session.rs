//! Sessions of the console. The browser keeps an identifier and a key in a cookie that scripts cannot read; the database
//! keeps the provider's tokens, encrypted with that key. So neither has them alone.

use std::sync::Arc;
use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use openidconnect::{
    AccessToken, CsrfToken, Nonce, NonceVerifier, OAuth2TokenResponse as _, PkceCodeChallenge, PkceCodeVerifier,
    TokenResponse as _,
};
use serde::{Deserialize, Serialize};
use tokio::sync::Mutex;
use tokio::task::JoinError;
use tracing::Instrument as _;

use super::access_token::Oidc;
use super::claims::{self, is_stale};
use super::fetch::Away;
use super::id_token::{self, IdToken, TokenResponse};
use super::provider::{Denial, Provider};
use super::return_page::ReturnPage;
use super::tokens::{Tokens, open, seal};
use crate::http::access::SignInOptions;
use crate::http::access::cookies::{ID_BYTES, KEY_BYTES, Site, session_ended};
use crate::http::access::{Authentication, Caller, Role};
use crate::http::problem::{Kind, Problem};
use vibrissa_edge::clock::wall_clock;
use vibrissa_host::{random, task};
use vibrissa_store::Store;
use vibrissa_store::secret::Secret;
use vibrissa_store::sessions::SessionRow;

/// Longest time of a session, s.
pub(in crate::http) const SESSION_S: i64 = 12 * 3600;
/// Number of renewals that can be under way at once; those of one session follow each other.
const RENEWALS: usize = 16;
/// Number of reads of a session whose refresh token the provider refuses, and the pause between them.
const READS: usize = 50;
const PAUSE: Duration = Duration::from_millis(100);

/// Signs people in with the identity provider. Clones share their state.
#[derive(Debug, Clone)]
pub(in crate::http) struct SignIn {
    provider: Provider,
    oidc: Oidc,
    site: Arc<Site>,
    renewals: Arc<[Arc<Mutex<()>>; RENEWALS]>,
}

/// A sign-in that is under way at the provider. The browser keeps it in a cookie.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::http) struct Attempt {
    /// Ties the provider's answer to this browser.
    pub state: String,
    /// Ties the ID token to this attempt.
    nonce: String,
    /// Secret of PKCE: who intercepts the code cannot redeem it.
    verifier: String,
    /// Page to show afterwards.
    pub to: ReturnPage,
}

impl Attempt {
    /// A new attempt.
    #[must_use]
    pub(in crate::http) fn new(to: ReturnPage) -> Self {
        let (state, nonce) = (CsrfToken::new_random(), Nonce::new_random());
        let (_, verifier) = PkceCodeChallenge::new_random_sha256();
        let [state, nonce] = [state.into_secret(), nonce.secret().clone()];
        Self { state, nonce, verifier: verifier.into_secret(), to }
    }
}

/// A new session.
#[derive(Debug)]
pub(in crate::http) struct Begun {
    /// Value of the cookie.
    pub cookie: Secret,
    /// Row of the session.
    pub row: SessionRow,
    /// The person.
    pub caller: Caller,
}

/// A session that its person ends.
#[derive(Debug)]
pub(in crate::http) struct Ending {
    /// Key of its row.
    pub session_id: Vec<u8>,
    /// Actor, as at the sign-in.
    pub actor: String,
    /// Name of the person.
    pub name: String,
    /// Role of the person.
    pub role: Role,
    id_token: Option<String>,
}

/// Why a sign-in failed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::http) enum Failure {
    /// The person has no role here.
    NoRole(String),
    /// The provider does not answer, or its answer is not valid.
    Provider(String),
}

impl SignIn {
    pub(super) fn new(issuer: &str, options: &SignInOptions, oidc: Oidc) -> Self {
        let provider = Provider::new(issuer, options);
        let site = Arc::new(Site::of(&options.public_url));
        Self { provider, oidc, site, renewals: Arc::new(std::array::from_fn(|_| Arc::default())) }
    }

    /// Where browsers reach the console.
    #[must_use]
    pub(in crate::http) fn site(&self) -> &Site {
        &self.site
    }

    /// Where the browser goes for an attempt.
    ///
    /// # Errors
    /// The provider does not answer.
    pub(in crate::http) async fn authorization_url(&self, attempt: &Attempt) -> Result<String, Problem> {
        let verifier = PkceCodeVerifier::new(attempt.verifier.clone());
        let (state, nonce) = (CsrfToken::new(attempt.state.clone()), Nonce::new(attempt.nonce.clone()));
        self.provider.authorization_url(state, nonce, &verifier).await.map_err(|Away(what)| away(&what))
    }

    /// Whether an answer that names its issuer comes from this provider (RFC 9207).
    #[must_use]
    pub(in crate::http) fn is_of_provider(&self, issuer: Option<&str>) -> bool {
        issuer.is_none_or(|issuer| issuer == self.oidc.issuer())
    }

    /// The session for a code that the provider has given to this attempt.
    ///
    /// # Errors
    /// The provider refuses the code, its tokens are not valid, or they carry no role.
    pub(in crate::http) async fn begin(&self, attempt: &Attempt, code: String) -> Result<Begun, Failure> {
        let verifier = PkceCodeVerifier::new(attempt.verifier.clone());
        let answer = self.provider.redeem(code, verifier).await.map_err(|denial| match denial {
            Denial::Refused(what) | Denial::Away(what) => Failure::Provider(what),
        })?;
        let invalid = |problem: Problem| {
            let failure = if problem.kind == Kind::Forbidden { Failure::NoRole } else { Failure::Provider };
            failure(problem.detail)
        };
        let id_token = answer.id_token().ok_or_else(|| Failure::Provider("no ID token".to_owned()))?;
        let nonce = Nonce::new(attempt.nonce.clone());
        let subject = self.subject(id_token, answer.access_token(), &nonce).await.map_err(invalid)?;
        let claims = self.oidc.verified(answer.access_token().secret()).await.map_err(invalid)?;
        if claims::subject(&claims) != Some(&subject) {
            return Err(Failure::Provider("the tokens are about two different people".to_owned()));
        }
        let caller = self.oidc.allowed(&claims).map_err(invalid)?;
        let failed = |problem: Problem| Failure::Provider(problem.detail);
        let bytes = random::bytes::<{ ID_BYTES + KEY_BYTES }>();
        let now_us = wall_clock().0 as i64;
        let row = SessionRow {
            session_id: blake3::hash(&bytes[..ID_BYTES]).as_bytes().to_vec(),
            actor: caller.actor.clone(),
            sealed: seal(&Tokens::of(&answer, None), &bytes[ID_BYTES..]).map_err(failed)?,
            created_us: now_us,
            expires_us: now_us + SESSION_S * 1_000_000,
        };
        Ok(Begun { cookie: Secret::new(URL_SAFE_NO_PAD.encode(bytes)), row, caller })
    }

    /// The subject of an ID token for this client.
    async fn subject(
        &self,
        id_token: &IdToken,
        access_token: &AccessToken,
        nonce: impl NonceVerifier,
    ) -> Result<String, Problem> {
        let client_id = &self.provider.options().client_id;
        id_token::subject(&self.oidc, client_id, (id_token, access_token), nonce).await
    }

    /// The caller whose browser has this cookie. Tokens that expire are renewed.
    ///
    /// # Errors
    /// The session has ended, or the database or the provider does not answer.
    pub(in crate::http) async fn caller(&self, store: &Store, cookie: &Secret) -> Result<Caller, Problem> {
        let (row, mut tokens, _) = opened(store, cookie).await?.ok_or_else(session_ended)?;
        if is_stale(&tokens.access_token) {
            tokens = self.renewed(store, cookie, &row.session_id).await?;
        }
        let claims = self.oidc.verified(&tokens.access_token).await?;
        // An older version has not checked renewals.
        if claims::subject(&claims) != tokens.subject().as_deref() {
            return self.ends(store, &row, "the access token is about another person").await;
        }
        let caller = self.oidc.allowed(&claims)?;
        Ok(Caller { authentication: Authentication::Session, expires_us: Some(row.expires_us), ..caller })
    }

    /// The session with new tokens.
    async fn renewed(&self, store: &Store, cookie: &Secret, session_id: &[u8]) -> Result<Tokens, Problem> {
        let place = usize::from(session_id.first().copied().unwrap_or_default()) % RENEWALS;
        let turn = self.renewals[place].clone().lock_owned().await;
        let (sign_in, store, cookie) = (self.clone(), store.clone(), cookie.clone());
        // A renewal outlives its request: the provider gives each refresh token once, and its new one must be stored.
        let renewal = async move {
            let _turn = turn;
            sign_in.renew(&store, &cookie).await
        };
        let failed = |problem: JoinError| Problem::new(Kind::Internal, format!("cannot renew a session: {problem}"));
        task::spawn(renewal.in_current_span()).await.map_err(failed)?
    }

    async fn renew(&self, store: &Store, cookie: &Secret) -> Result<Tokens, Problem> {
        // Another request may have renewed them meanwhile.
        let (row, tokens, key) = opened(store, cookie).await?.ok_or_else(session_ended)?;
        if !is_stale(&tokens.access_token) {
            return Ok(tokens);
        }
        let answer = match self.provider.renew(tokens.refresh_token.clone()).await {
            Ok(answer) => answer,
            Err(Denial::Refused(what)) => return self.refused(store, cookie, &row, &what).await,
            Err(Denial::Away(what)) => return Err(away(&what)),
        };
        let checked = self.is_of_the_same_person(&tokens, &answer).await;
        if let Err(problem) = &checked
            && problem.kind != Kind::Unavailable
        {
            return self.ends(store, &row, &problem.detail).await;
        }
        // Also without the provider's keys: the old refresh token is spent, and each use of the new tokens is checked.
        let new = Tokens::of(&answer, Some(tokens));
        if store.reseal_session(&row.session_id, &row.sealed, &seal(&new, &key)?).await? {
            return checked.map(|()| new);
        }
        // Another supervisor has stored its own meanwhile, or the session has ended.
        opened(store, cookie).await?.map(|(_, tokens, _)| tokens).ok_or_else(session_ended)
    }

    /// The tokens of a session whose refresh token the provider refuses. Another supervisor of this database may have used
    /// it just before: it stores the new tokens soon. Otherwise the session ends.
    async fn refused(&self, store: &Store, cookie: &Secret, old: &SessionRow, what: &str) -> Result<Tokens, Problem> {
        for _ in 0..READS {
            let (row, tokens, _) = opened(store, cookie).await?.ok_or_else(session_ended)?;
            if row.sealed != old.sealed {
                return Ok(tokens);
            }
            tokio::time::sleep(PAUSE).await;
        }
        self.ends(store, old, what).await
    }

    /// Whether the tokens of a renewal are about the person who signed in (OpenID Connect Core 1.0, 12.2).
    async fn is_of_the_same_person(&self, before: &Tokens, answer: &TokenResponse) -> Result<(), Problem> {
        let nonce = |answer: Option<&Nonce>| match answer {
            Some(answer) if Some(answer.secret()) != before.nonce().as_ref() => {
                Err("its nonce is another one".to_owned())
            }
            Some(_) | None => Ok(()),
        };
        let another = |which: &str| {
            Problem::new(Kind::Unauthenticated, format!("the {which} token of the renewal is about another person"))
        };
        let person = before.subject();
        // The provider need not repeat the ID token.
        if let Some(id_token) = answer.id_token()
            && Some(self.subject(id_token, answer.access_token(), nonce).await?) != person
        {
            return Err(another("ID"));
        }
        let claims = self.oidc.verified(answer.access_token().secret()).await?;
        if claims::subject(&claims) == person.as_deref() { Ok(()) } else { Err(another("access")) }
    }

    /// Ends a session that the provider does not continue.
    async fn ends<T>(&self, store: &Store, row: &SessionRow, what: &str) -> Result<T, Problem> {
        tracing::info!(actor = row.actor, what, "a session of the console ends");
        store.end_refused_session(&row.session_id, &row.sealed).await?;
        Err(session_ended())
    }

    /// The session that a person ends; `None` if it has ended. It needs no answer of the provider: the stored tokens were
    /// verified before.
    ///
    /// # Errors
    /// The database does not answer.
    pub(in crate::http) async fn ending(&self, store: &Store, cookie: &Secret) -> Result<Option<Ending>, Problem> {
        let Some((row, tokens, _)) = opened(store, cookie).await? else { return Ok(None) };
        let claims = claims::unverified(&tokens.access_token).unwrap_or_default();
        // Another version of the configuration may find no role in them.
        let (name, role) =
            self.oidc.allowed(&claims).map_or((row.actor.clone(), Role::Viewer), |caller| (caller.name, caller.role));
        Ok(Some(Ending { session_id: row.session_id, actor: row.actor, name, role, id_token: tokens.id_token }))
    }

    /// Where the browser signs out at the provider, too.
    pub(in crate::http) async fn end_session_url(&self, ending: &Ending) -> Option<String> {
        self.provider.end_session_url(ending.id_token.as_deref()).await
    }
}

fn away(what: &str) -> Problem {
    Problem::new(Kind::Unavailable, format!("the identity provider is not available: {what}"))
}

/// The session of a cookie with its tokens and its key; `None` if it has ended.
async fn opened(store: &Store, cookie: &Secret) -> Result<Option<(SessionRow, Tokens, Vec<u8>)>, Problem> {
    let Ok(bytes) = URL_SAFE_NO_PAD.decode(cookie.reveal()) else { return Ok(None) };
    if bytes.len() != ID_BYTES + KEY_BYTES {
        return Ok(None);
    }
    let (id, key) = bytes.split_at(ID_BYTES);
    let row = store.session(blake3::hash(id).as_bytes()).await?;
    let row = row.filter(|row| row.holds(wall_clock().0 as i64));
    Ok(row.and_then(|row| open(&row.sealed, key).map(|tokens| (row, tokens, key.to_vec()))))
}
