-- The overview counts the changes since a time: it reads them from an index, not from all that ever were.
CREATE INDEX trims_in_order ON trims (detected_us, robot_id);
CREATE INDEX setpoints_in_order ON setpoints (issued_us, state, robot_id);
CREATE INDEX actions_in_order ON actions (asked_us);

-- Whiskers by model, to tell where a calibration is used.
CREATE INDEX whiskers_of_model ON whiskers (model, robot_id) WHERE position IS NOT NULL;

-- The list of compensations shows the newest setpoint of each. Without the index it reads all setpoints for each row.
CREATE INDEX setpoints_of_compensation ON setpoints (compensation_id, epoch, version);
