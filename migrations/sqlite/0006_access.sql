-- Who may ask for what, besides those whom an identity provider vouches for.

-- A token of the API. It is shown once, when it is made: `secret_hash` is the BLAKE3 hash of its secret half,
-- `token_id` its other half. `role` is VIEWER, OPERATOR, ENGINEER or ADMIN, each with the rights of those before it;
-- `fleets` those that it is bound to, separated by commas, NULL for all.
CREATE TABLE api_tokens (
    token_id    TEXT   PRIMARY KEY,
    name        TEXT   NOT NULL,
    role        TEXT   NOT NULL CHECK (role IN ('VIEWER', 'OPERATOR', 'ENGINEER', 'ADMIN')),
    fleets      TEXT,
    secret_hash BLOB   NOT NULL,
    created_us  INTEGER NOT NULL,
    created_by  TEXT   NOT NULL,
    expires_us  INTEGER NOT NULL,
    revoked_us  INTEGER
);
