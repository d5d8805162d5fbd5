-- Upkeep goes through the boots of each robot from the newest to the oldest, and removes those to which nothing refers.
CREATE INDEX boots_of_robot ON boots (robot_id, boot, first_seen_us);
