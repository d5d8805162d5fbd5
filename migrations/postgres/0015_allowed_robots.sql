-- Which robots people have allowed in a fleet. In force is the highest version; without a row, or where `robots` is NULL,
-- everybody is allowed. `robots` has a name on each line; an empty text allows nobody. `action_id` is the entry in the audit log.
-- The newest 20 versions of a fleet are kept.
CREATE TABLE allowed_robots (
    fleet      TEXT   NOT NULL,
    version    BIGINT NOT NULL,
    robots     TEXT,
    changed_us BIGINT NOT NULL,
    changed_by TEXT   NOT NULL,
    reason     TEXT,
    action_id  BIGINT NOT NULL REFERENCES actions,
    PRIMARY KEY (fleet, version)
);

-- Robots that are not allowed and have tried, as the fleet's owner has seen them since it took the fleet up: at most 1,024 of a
-- fleet. `tries` counts their messages.
CREATE TABLE turned_away (
    fleet    TEXT   NOT NULL,
    robot    TEXT   NOT NULL,
    tries    BIGINT NOT NULL,
    first_us BIGINT NOT NULL,
    last_us  BIGINT NOT NULL,
    PRIMARY KEY (fleet, robot)
);
