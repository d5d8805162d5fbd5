-- Since when a whisker is on no layout of its robot, NULL while it is on one. Whiskers that were never touched and took part in
-- nothing are removed after a day. Those that went before this migration count from their next layout on.
ALTER TABLE whiskers ADD COLUMN absent_us BIGINT;
CREATE INDEX whiskers_absent ON whiskers (absent_us) WHERE absent_us IS NOT NULL;

-- Without these, the removal of a whisker would read all candidates and compensations.
CREATE INDEX compensation_candidates_of_whisker ON compensation_candidates (whisker_id);
CREATE INDEX compensations_of_any_compensator ON compensations (compensator_whisker_id);
