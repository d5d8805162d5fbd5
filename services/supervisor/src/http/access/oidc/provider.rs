//! The identity provider for the sign-in at the console: its endpoints, and tokens for a code or a refresh token. The
//! protocol is that of `openidconnect`.

use std::str::FromStr as _;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use openidconnect::core::{
    CoreAuthDisplay, CoreAuthPrompt, CoreErrorResponseType, CoreGenderClaim, CoreJweContentEncryptionAlgorithm,
    CoreResponseType, CoreRevocableToken, CoreRevocationErrorResponse, CoreTokenIntrospectionResponse,
};
use openidconnect::{
    AuthUrl, AuthenticationFlow, AuthorizationCode, ClientId, ClientSecret, CsrfToken, EndSessionUrl, EndpointNotSet,
    EndpointSet, IssuerUrl, JsonWebKeySet, LogoutRequest, Nonce, PkceCodeChallenge, PkceCodeVerifier,
    PostLogoutRedirectUrl, RedirectUrl, RefreshToken, RequestTokenError, Scope, StandardErrorResponse, TokenUrl,
};
use tokio::time::Instant;

use super::fetch::{self, Away, Discovery, blocking};
use super::id_token::{IdToken, MoreClaims, TokenResponse, VerifyingKey};
use crate::http::access::SignInOptions;
use vibrissa_protocol::plain;

/// Time for which the endpoints are remembered.
const FRESH_FOR: Duration = Duration::from_secs(600);

/// This service as a client of the provider.
type Client = openidconnect::Client<
    MoreClaims,
    CoreAuthDisplay,
    CoreGenderClaim,
    CoreJweContentEncryptionAlgorithm,
    VerifyingKey,
    CoreAuthPrompt,
    StandardErrorResponse<CoreErrorResponseType>,
    TokenResponse,
    CoreTokenIntrospectionResponse,
    CoreRevocableToken,
    CoreRevocationErrorResponse,
    EndpointSet,
    EndpointNotSet,
    EndpointNotSet,
    EndpointNotSet,
    EndpointSet,
    EndpointNotSet,
>;

/// Why the provider gave no tokens.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Denial {
    /// It refuses them: the code or the refresh token is not valid any more.
    Refused(String),
    /// It does not answer, or not as expected.
    Away(String),
}

impl From<Away> for Denial {
    fn from(Away(what): Away) -> Self {
        Self::Away(what)
    }
}

impl From<RequestTokenError<Away, StandardErrorResponse<CoreErrorResponseType>>> for Denial {
    fn from(problem: RequestTokenError<Away, StandardErrorResponse<CoreErrorResponseType>>) -> Self {
        match problem {
            RequestTokenError::ServerResponse(answer) if *answer.error() == CoreErrorResponseType::InvalidGrant => {
                Self::Refused(answer.to_string())
            }
            // About this client, not about the person: a wrong secret must end no session.
            RequestTokenError::ServerResponse(answer) => Self::Away(answer.to_string()),
            RequestTokenError::Request(away) => away.into(),
            RequestTokenError::Parse(problem, _) => {
                let (place, what) = (problem.path().to_string(), plain::json(&problem.inner().to_string()));
                Self::Away(format!("unexpected JSON from the provider: {place}: {what}"))
            }
            RequestTokenError::Other(what) => Self::Away(what),
        }
    }
}

/// A provider. Clones share what is remembered.
#[derive(Debug, Clone)]
pub(super) struct Provider {
    issuer: Arc<str>,
    options: Arc<SignInOptions>,
    known: Arc<Mutex<Option<(Instant, Discovery)>>>,
}

impl Provider {
    pub(super) fn new(issuer: &str, options: &SignInOptions) -> Self {
        Self { issuer: issuer.into(), options: Arc::new(options.clone()), known: Arc::default() }
    }

    pub(super) fn options(&self) -> &SignInOptions {
        &self.options
    }

    /// The provider's endpoints.
    async fn endpoints(&self) -> Result<Discovery, Away> {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if let Some((fetched, endpoints)) = known
            && fetched.elapsed() < FRESH_FOR
        {
            return Ok(endpoints);
        }
        let issuer = self.issuer.clone();
        let endpoints = blocking(move || fetch::discover(&issuer)).await?;
        if endpoints.issuer.as_deref() != Some(&*self.issuer) {
            let stated_issuer = endpoints.issuer.unwrap_or_default();
            return Err(Away(format!(
                "it calls itself {stated_issuer:?}, but http.oidc_issuer is {:?}: both must be equal to the last character",
                self.issuer
            )));
        }
        *self.known.lock().unwrap_or_else(PoisonError::into_inner) = Some((Instant::now(), endpoints.clone()));
        Ok(endpoints)
    }

    async fn client(&self) -> Result<Client, Away> {
        let endpoints = self.endpoints().await?;
        let invalid =
            |problem: url::ParseError| Away(format!("an address is not a URL: {}", plain::url(&problem.to_string())));
        let options = &self.options;
        let client_id = ClientId::new(options.client_id.clone());
        let issuer = IssuerUrl::new(self.issuer.to_string()).map_err(invalid)?;
        let authorization = web("authorization_endpoint", endpoints.authorization_endpoint)?;
        let token = web("token_endpoint", endpoints.token_endpoint)?;
        let redirect = format!("{}/auth/callback", options.public_url);
        // Without keys: `id_token` gets the one of each token.
        let client: Client = openidconnect::Client::new(client_id, issuer, JsonWebKeySet::default())
            .set_auth_uri(AuthUrl::new(authorization).map_err(invalid)?)
            .set_token_uri(TokenUrl::new(token).map_err(invalid)?)
            .set_redirect_uri(RedirectUrl::new(redirect).map_err(invalid)?);
        Ok(match &options.client_secret {
            Some(secret) => client.set_client_secret(ClientSecret::new(secret.reveal().to_owned())),
            None => client,
        })
    }

    /// Where the browser goes to sign in.
    pub(super) async fn authorization_url(
        &self,
        state: CsrfToken,
        nonce: Nonce,
        verifier: &PkceCodeVerifier,
    ) -> Result<String, Away> {
        let flow = AuthenticationFlow::<CoreResponseType>::AuthorizationCode;
        let client = self.client().await?;
        let request = client.authorize_url(flow, || state, || nonce);
        let request = request.add_scopes(self.options.scopes.iter().cloned().map(Scope::new));
        let challenge = PkceCodeChallenge::from_code_verifier_sha256(verifier);
        Ok(request.set_pkce_challenge(challenge).url().0.into())
    }

    /// The tokens for a code.
    pub(super) async fn redeem(&self, code: String, verifier: PkceCodeVerifier) -> Result<TokenResponse, Denial> {
        let client = self.client().await?;
        blocking(move || {
            let request = client.exchange_code(AuthorizationCode::new(code)).set_pkce_verifier(verifier);
            request.request(&fetch::send).map_err(Denial::from)
        })
        .await
    }

    /// New tokens for a refresh token.
    pub(super) async fn renew(&self, refresh_token: Option<String>) -> Result<TokenResponse, Denial> {
        let gone = || Denial::Refused("the provider gave no refresh token".to_owned());
        let refresh_token = RefreshToken::new(refresh_token.ok_or_else(gone)?);
        let client = self.client().await?;
        blocking(move || client.exchange_refresh_token(&refresh_token).request(&fetch::send).map_err(Denial::from))
            .await
    }

    /// Where the browser signs out at the provider; `None` if the provider has no such page.
    pub(super) async fn end_session_url(&self, id_token: Option<&str>) -> Option<String> {
        let endpoint = web("end_session_endpoint", self.endpoints().await.ok()?.end_session_endpoint).ok()?;
        let back = PostLogoutRedirectUrl::new(format!("{}/", self.options.public_url)).ok()?;
        let request = LogoutRequest::from(EndSessionUrl::new(endpoint).ok()?)
            .set_client_id(ClientId::new(self.options.client_id.clone()))
            .set_post_logout_redirect_uri(back);
        let hint = id_token.and_then(|token| IdToken::from_str(token).ok());
        let request = match hint {
            Some(hint) => request.set_id_token_hint(&hint),
            None => request,
        };
        Some(request.http_get_url().into())
    }
}

/// An endpoint, if it is an address that a browser or this service may open.
fn web(name: &str, address: Option<String>) -> Result<String, Away> {
    let address = address.ok_or_else(|| Away(format!("it publishes no {name}")))?;
    let is_web = url::Url::parse(&address).is_ok_and(|url| matches!(url.scheme(), "https" | "http"));
    if is_web { Ok(address) } else { Err(Away(format!("its {name} is no address of the web: {address:?}"))) }
}
