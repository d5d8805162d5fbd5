-- The counts of robots, arrays and fleets need condition and fault of the few whiskers that are not sound. Reading them
-- from the index costs a hundredth of reading all rows, which carry the whiskers' states.
CREATE INDEX whiskers_in_need ON whiskers (robot_id, array_id, condition, fault, whisker_id)
    WHERE position IS NOT NULL AND (condition <> 'HEALTHY' OR fault IS NOT NULL);

-- Compensations that have not ended, by compensator and by target: they are few among all that ever were.
CREATE INDEX compensations_of_compensator ON compensations (compensator_whisker_id) WHERE ended_us IS NULL;
CREATE INDEX compensations_not_ended ON compensations (target_whisker_id) WHERE ended_us IS NULL;
