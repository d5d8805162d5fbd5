-- The timeline shows the events of a span of time, and those of one robot in it. Contacts are not part of it.
CREATE INDEX events_by_time ON events (recorded_us) WHERE audience <> 'KAFKA';
CREATE INDEX events_of_robot ON events (robot_id, recorded_us) WHERE audience <> 'KAFKA' AND robot_id IS NOT NULL;
