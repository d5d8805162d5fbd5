-- Upkeep finds old rows by their time. Numbers do not tell the oldest: the clock may have been ahead for a while.
CREATE INDEX health_changes_by_time ON health_changes (recorded_us);
CREATE INDEX touch_tests_by_end ON touch_tests (ended_us) WHERE ended_us IS NOT NULL;
CREATE INDEX alarm_shelves_by_end ON alarm_shelves (until_us);
