//! The audit log belongs to a role of its own, if the database has one: `deploy/postgres/supervisor.sql`. The supervisors'
//! role creates the table; afterwards it hands it over, and cannot delete or change answered actions any more.

use sqlx::postgres::PgPool;
use tracing::{info, warn};

/// Hands the audit log over to its owner, or warns that there is none.
pub(crate) async fn protect(pool: &PgPool) -> sqlx::Result<()> {
    const STANDING: &str = "SELECT pg_has_role(relowner, 'USAGE'), to_regprocedure('public.protect_audit_log()') IS NOT NULL, \
         current_setting('is_superuser') = 'on' FROM pg_class WHERE oid = to_regclass('public.actions')";
    let standing: Option<(bool, bool, bool)> = sqlx::query_as(STANDING).fetch_optional(pool).await?;
    match standing {
        Some((true, true, false)) => {
            sqlx::query("SELECT public.protect_audit_log()").execute(pool).await?;
            info!("the audit log belongs to the role supervisor_owner now: this supervisor cannot delete it");
        }
        Some((true, false, false)) => warn!(
            "the supervisors' database role can delete the audit log: run deploy/postgres/supervisor.sql, which makes \
             another role its owner"
        ),
        Some((_, _, true)) => warn!(
            "the supervisors' database role is a superuser and can delete the audit log: connect as a role of its own, see \
             deploy/postgres/supervisor.sql"
        ),
        // A role without rights on the owner is the one that is wanted.
        Some(_) | None => {}
    }
    Ok(())
}
