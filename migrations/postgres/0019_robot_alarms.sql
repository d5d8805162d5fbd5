-- Alarms about a robot as a whole.

-- An alarm concerns a whisker, or a robot as a whole: exactly one of `whisker_id` and `robot_id` is set. Of a robot's alarms of
-- one kind at most one stands.
ALTER TABLE alarms ALTER COLUMN whisker_id DROP NOT NULL;
ALTER TABLE alarms ADD COLUMN robot_id BIGINT REFERENCES robots;
ALTER TABLE alarms ADD CONSTRAINT alarms_subject CHECK ((whisker_id IS NULL) <> (robot_id IS NULL));
CREATE INDEX alarms_of_robot ON alarms (robot_id, raised_us) WHERE robot_id IS NOT NULL;
CREATE INDEX alarms_standing_of_robot ON alarms (robot_id, kind) WHERE cleared_us IS NULL AND robot_id IS NOT NULL;

-- The list of alarms begins with the newest.
CREATE INDEX alarms_in_order ON alarms (raised_us, alarm_id);

-- Shelved are the alarms of a kind about a whisker, or about a robot as a whole.
ALTER TABLE alarm_shelves ALTER COLUMN whisker_id DROP NOT NULL;
ALTER TABLE alarm_shelves ADD COLUMN robot_id BIGINT REFERENCES robots;
ALTER TABLE alarm_shelves ADD CONSTRAINT alarm_shelves_subject CHECK ((whisker_id IS NULL) <> (robot_id IS NULL));
CREATE INDEX alarm_shelves_of_robot ON alarm_shelves (robot_id, kind) WHERE robot_id IS NOT NULL;
