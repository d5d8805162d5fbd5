-- Places of contacts: robots also know distances from the base, the tip, or nothing.

-- `place`: RATIO, DISTANCE, TIP or UNKNOWN, as the robot stated it. `ratio`: contact ratio, the robot's or `distance_mm` /
-- the length estimated before the contact; NULL if the place is unknown. `distance_mm`: the robot's measurement, or NULL.
ALTER TABLE contacts ADD COLUMN place TEXT NOT NULL DEFAULT 'RATIO';
ALTER TABLE contacts ADD COLUMN distance_mm DOUBLE PRECISION;
ALTER TABLE contacts ALTER COLUMN ratio DROP NOT NULL;
