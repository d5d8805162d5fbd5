-- What supervisors say of their clocks, so that they can compare them.

-- `time_to_live_us` is the time to live of the supervisor's leases; 0 if it is an older program. `clock_ahead_us` and
-- `robots_ahead_us` tell how far the supervisor's clock, and the median clock of the robots that it hears, are ahead of this
-- database's clock, in µs; NULL if unknown. A supervisor whose clock most others contradict says so in `clock_wrong`: it
-- gives its leases to one that is not contradicted.
ALTER TABLE supervisors ADD COLUMN time_to_live_us BIGINT NOT NULL DEFAULT 0;
ALTER TABLE supervisors ADD COLUMN clock_ahead_us BIGINT;
ALTER TABLE supervisors ADD COLUMN robots_ahead_us BIGINT;
ALTER TABLE supervisors ADD COLUMN clock_wrong BOOLEAN NOT NULL DEFAULT FALSE;
