//! Tokens of the API, `vbr_ID_SECRET`. The database stores the ID and a hash of the secret.

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use subtle::ConstantTimeEq as _;
use vibrissa_edge::fleets::FleetPattern;
use vibrissa_host::random;

use super::{Authentication, Caller, Role, Scope};
use vibrissa_store::tokens::TokenRow;
use vibrissa_store::{Store, StoreError};

const PREFIX: &str = "vbr_";
/// Length of the ID, in bytes.
const ID_BYTES: usize = 6;
/// Length of the secret half, in bytes.
const SECRET_BYTES: usize = 32;

/// Properties of a new token.
#[derive(Debug, Clone)]
pub struct NewToken {
    /// Name for people, for example its purpose.
    pub name: String,
    /// Rights of its holder.
    pub role: Role,
    /// Fleets that its holder may access.
    pub scope: Scope,
    /// Expiry, µs since 1970 UTC.
    pub expires_us: i64,
    /// Actor who creates it.
    pub created_by: String,
}

/// Creates a token and returns it. Only its hash is stored, so it cannot be shown again.
///
/// # Errors
/// The database cannot be written.
pub async fn create(store: &Store, new: &NewToken, now_us: i64) -> anyhow::Result<(String, TokenRow)> {
    let (id, secret) = (random::bytes::<ID_BYTES>(), random::bytes::<SECRET_BYTES>());
    let fleets = match &new.scope {
        Scope::All => None,
        Scope::Only(fleets) => Some(fleets.iter().map(FleetPattern::as_str).collect::<Vec<_>>().join(",")),
    };
    let row = TokenRow {
        token_id: id.iter().map(|byte| format!("{byte:02x}")).collect(),
        name: new.name.clone(),
        role: new.role.word().to_owned(),
        fleets,
        secret_hash: blake3::hash(&secret).as_bytes().to_vec(),
        created_us: now_us,
        created_by: new.created_by.clone(),
        expires_us: new.expires_us,
        revoked_us: None,
    };
    store.add_token(&row).await?;
    Ok((format!("{PREFIX}{}_{}", row.token_id, URL_SAFE_NO_PAD.encode(secret)), row))
}

/// Whether the token has the format of this service's own tokens.
#[must_use]
pub fn is_ours(token: &str) -> bool {
    token.starts_with(PREFIX)
}

/// Name of the token's holder in the audit log: `token:NAME#ID`. Several tokens may share a name; the ID makes each one
/// an actor of its own. It follows the last `#`, because a name may contain others.
fn actor(row: &TokenRow) -> String {
    format!("token:{}#{}", row.name, row.token_id)
}

/// ID and hash of the secret of a token; `None` if it has another format.
pub(super) fn parse(token: &str) -> Option<(&str, [u8; 32])> {
    let (id, secret) = token.strip_prefix(PREFIX)?.split_once('_')?;
    let secret = URL_SAFE_NO_PAD.decode(secret).ok()?;
    Some((id, *blake3::hash(&secret).as_bytes()))
}

/// The caller that a token with this ID and this hash of its secret identifies; `None` if the token is unknown, expired or
/// revoked.
///
/// # Errors
/// The database cannot be read.
pub(super) async fn caller(
    store: &Store,
    id: &str,
    hash: &[u8; 32],
    now_us: i64,
) -> Result<Option<Caller>, StoreError> {
    let Some(row) = store.token(id).await? else { return Ok(None) };
    let is_right = bool::from(hash.ct_eq(&row.secret_hash));
    if !is_right || row.revoked_us.is_some() || row.expires_us <= now_us {
        return Ok(None);
    }
    let Some(role) = Role::of_word(&row.role) else { return Ok(None) };
    let scope = match &row.fleets {
        None => Scope::All,
        Some(fleets) => Scope::of(fleets.split(',').filter_map(|fleet| FleetPattern::new(fleet).ok())),
    };
    let (actor, authentication) = (actor(&row), Authentication::Token);
    Ok(Some(Caller { name: row.name, actor, role, scope, authentication, expires_us: Some(row.expires_us) }))
}
