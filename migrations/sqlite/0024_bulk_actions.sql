-- Actions on many robots, whiskers, alarms or fleets. One action, which is DONE at once, stands for the request: `subjects` is the
-- number of its subjects, and NULL for other actions. Each subject has an action of its own, with the request's as `parent_id`.
-- It is not executed before `not_before_us`, so that not all robots act at the same moment. A request can be stopped: the actions
-- that are pending then become REFUSED. The owner of a fleet may execute one of them at that moment; then it becomes DONE.
ALTER TABLE actions ADD COLUMN parent_id INTEGER REFERENCES actions;
ALTER TABLE actions ADD COLUMN not_before_us INTEGER NOT NULL DEFAULT 0;
ALTER TABLE actions ADD COLUMN subjects INTEGER;
CREATE INDEX actions_of_parent ON actions (parent_id, state) WHERE parent_id IS NOT NULL;
CREATE INDEX actions_for_many ON actions (action_id) WHERE subjects IS NOT NULL;
