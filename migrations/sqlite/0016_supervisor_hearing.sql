-- What supervisors say of how they hear their broker.

-- Fleets, separated by commas: in `deaf` those that the supervisor does not hear, in `heard` those that it has just proved to hear
-- without owning them. An owner that is deaf for a fleet gives it to a supervisor that has proved to hear it. A supervisor that
-- says nothing here is taken to hear.
ALTER TABLE supervisors ADD COLUMN deaf TEXT NOT NULL DEFAULT '';
ALTER TABLE supervisors ADD COLUMN heard TEXT NOT NULL DEFAULT '';
