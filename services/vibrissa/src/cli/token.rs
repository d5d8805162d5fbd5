//! `vibrissa token`: creates, lists and revokes API tokens.

use std::io::Write;
use std::time::Duration;

use anyhow::bail;
use clap::{Args, Subcommand};

use super::config::{DatabaseArgs, missing};
use super::serve::runtime;
use super::table::Table;
use super::words::one_of;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::fleets::FleetPattern;
use vibrissa_store::Store;
use vibrissa_store::time::Time;
use vibrissa_store::tokens::TOKENS_MAX;
use vibrissa_supervisor::http::access::token::{self, NewToken};
use vibrissa_supervisor::http::access::{Role, Scope};

/// Arguments of `vibrissa token`.
#[derive(Debug, Args)]
pub struct TokenArgs {
    #[command(subcommand)]
    command: TokenCommand,
}

#[derive(Debug, Subcommand)]
enum TokenCommand {
    /// Create a token and print it once; only its hash is stored.
    Create(CreateArgs),
    /// List the tokens with role, fleets and expiry, but without their secrets.
    List(ListArgs),
    /// Revoke a token immediately.
    Revoke(RevokeArgs),
}

#[derive(Debug, Args)]
struct CreateArgs {
    /// Role of the token; each role has the rights of those before it.
    #[arg(long, value_parser = one_of(Role::ALL.to_vec(), Role::word))]
    role: Role,
    /// Fleet that the token is limited to, or a pattern such as 'hall-*', which includes future fleets; may be given
    /// several times.
    #[arg(long, value_name = "FLEET", required_unless_present = "all_fleets")]
    fleet: Vec<FleetPattern>,
    /// Allow all fleets, including future ones.
    #[arg(long, conflicts_with = "fleet")]
    all_fleets: bool,
    /// Lifetime, such as 90d or 12h.
    #[arg(long, value_parser = lifetime, default_value = "90d")]
    expires: Duration,
    /// Name of the token for people and for the audit log.
    #[arg(long, value_parser = label)]
    name: Option<String>,
    #[command(flatten)]
    database: DatabaseArgs,
}

#[derive(Debug, Args)]
struct ListArgs {
    /// Print the tokens as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    database: DatabaseArgs,
}

#[derive(Debug, Args)]
struct RevokeArgs {
    /// Token ID, as printed by `list`.
    token_id: String,
    #[command(flatten)]
    database: DatabaseArgs,
}

/// Longest lifetime: ten years. No token is valid for ever.
const LIFETIME_MAX: Duration = Duration::from_secs(10 * 366 * 86_400);

fn lifetime(text: &str) -> Result<Duration, String> {
    let lifetime =
        humantime::parse_duration(text).map_err(|problem| format!("{problem}: use a duration such as 90d or 12h"))?;
    if lifetime.is_zero() || lifetime > LIFETIME_MAX {
        return Err("must be above zero and at most ten years".to_owned());
    }
    Ok(lifetime)
}

fn label(text: &str) -> Result<String, String> {
    let is_good = (1..=64).contains(&text.chars().count()) && !text.contains(char::is_control);
    if is_good {
        Ok(text.to_owned())
    } else {
        Err("must have 1 to 64 characters, and no control characters".to_owned())
    }
}

/// Creates, lists or revokes tokens.
///
/// # Errors
/// The database cannot be used, or the token does not exist.
pub fn run(args: &TokenArgs, out: &mut impl Write) -> anyhow::Result<()> {
    runtime()?.block_on(async {
        match &args.command {
            TokenCommand::Create(args) => create(args, out).await,
            TokenCommand::List(args) => list(args, out).await,
            TokenCommand::Revoke(args) => revoke(args, out).await,
        }
    })
}

async fn open(database: &DatabaseArgs) -> anyhow::Result<Store> {
    Ok(Store::open_for_command(&database.read_database()?).await?)
}

async fn create(args: &CreateArgs, out: &mut impl Write) -> anyhow::Result<()> {
    // A token may be created before the first start of the supervisor.
    let database = args.database.read()?.database;
    let new_file = missing(&database);
    let store = Store::open_for_command(&database).await?;
    let now_us = wall_clock().0 as i64;
    let scope = if args.all_fleets { Scope::All } else { Scope::of(args.fleet.iter().cloned()) };
    let new = NewToken {
        name: args.name.clone().unwrap_or_else(|| args.role.word().to_ascii_lowercase()),
        role: args.role,
        scope,
        expires_us: now_us.saturating_add(i64::try_from(args.expires.as_micros()).unwrap_or(i64::MAX)),
        created_by: "command line".to_owned(),
    };
    let (token, row) = token::create(&store, &new, now_us).await?;
    store.close().await;
    if let Some(path) = new_file {
        eprintln!(
            "vibrissa: warning: the database {} is new. A supervisor with another one does not know the token: name its database \
             with --database-url, and run this command as its user",
            path.display()
        );
    }
    eprintln!(
        "vibrissa: token {} ({}) for {}, valid until {}, in {database}. It is shown only once:",
        row.token_id,
        row.role,
        row.fleets.as_deref().unwrap_or("all fleets"),
        Time(row.expires_us)
    );
    writeln!(out, "{token}")?;
    Ok(())
}

async fn list(args: &ListArgs, out: &mut impl Write) -> anyhow::Result<()> {
    let store = open(&args.database).await?;
    let now_us = wall_clock().0 as i64;
    let tokens = store.tokens(now_us).await?;
    store.close().await;
    if tokens.len() as i64 == TOKENS_MAX {
        eprintln!("only {TOKENS_MAX} tokens are listed: the valid ones first, then the newest");
    }
    if args.json {
        let rows: Vec<_> = tokens
            .iter()
            .map(|row| {
                serde_json::json!({
                    "token_id": row.token_id, "name": row.name, "role": row.role,
                    "fleets": row.fleets.as_deref().map(|fleets| fleets.split(',').collect::<Vec<_>>()),
                    "created_at": Time(row.created_us), "created_by": row.created_by,
                    "expires_at": Time(row.expires_us), "revoked_at": row.revoked_us.map(Time),
                })
            })
            .collect();
        writeln!(out, "{}", serde_json::to_string_pretty(&rows)?)?;
        return Ok(());
    }
    let mut table = Table::new(["TOKEN", "NAME", "ROLE", "FLEETS", "CREATED", "STATE"]);
    for row in tokens {
        let state = match row.revoked_us {
            Some(revoked_us) => format!("revoked {}", Time(revoked_us)),
            None if row.expires_us <= now_us => format!("expired {}", Time(row.expires_us)),
            None => format!("valid until {}", Time(row.expires_us)),
        };
        let fleets = row.fleets.unwrap_or_else(|| "all".to_owned());
        table.row([row.token_id, row.name, row.role, fleets, Time(row.created_us).to_string(), state]);
    }
    write!(out, "{table}")?;
    Ok(())
}

async fn revoke(args: &RevokeArgs, out: &mut impl Write) -> anyhow::Result<()> {
    let store = open(&args.database).await?;
    let is_revoked = store.revoke_token(&args.token_id, wall_clock().0 as i64).await?;
    store.close().await;
    if !is_revoked {
        bail!("there is no valid token {:?}: see `vibrissa token list`", args.token_id);
    }
    writeln!(out, "revoked: {}", args.token_id)?;
    Ok(())
}
