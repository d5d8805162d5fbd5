-- The list of setpoints in a state reads the newest of them. Without the index it reads all setpoints that ever were.
CREATE INDEX setpoints_by_state ON setpoints (state, issued_us, robot_id);
