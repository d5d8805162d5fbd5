-- Sessions of the console, after signing in with the identity provider.

-- `session_id` is the BLAKE3 hash of the identifier in the browser's cookie. `sealed` holds the provider's tokens, encrypted with
-- a key that is only in the cookie: without it, nobody can use them. `actor` is that of the audit log.
CREATE TABLE console_sessions (
    session_id BYTEA   PRIMARY KEY,
    actor      TEXT    NOT NULL,
    sealed     BYTEA   NOT NULL,
    created_us BIGINT  NOT NULL,
    expires_us BIGINT  NOT NULL
);
CREATE INDEX console_sessions_by_expiry ON console_sessions (expires_us);
