-- The audit log: an action that has been answered is not changed any more.

-- Two columns are written after the answer, once, and an action of a request for many that was withdrawn may turn out to be
-- done already. Any other change of an answered row is left out.
CREATE TRIGGER answered_action_is_kept
BEFORE UPDATE OF fleet, robot, "array", whisker, compensation_id, alarm_id, kind, parameters, reason, actor, role, request_id,
    idempotency_key, asked_us, expires_us, state, problem, done_us, parent_id, not_before_us, shard ON actions
WHEN OLD.state <> 'PENDING' AND NOT (OLD.state = 'REFUSED' AND OLD.problem LIKE 'STOPPED:%' AND NEW.state = 'DONE')
BEGIN
    SELECT RAISE(IGNORE);
END;
CREATE TRIGGER answered_action_is_marked_once
BEFORE UPDATE OF subjects, test_id ON actions
WHEN OLD.state <> 'PENDING' AND (OLD.subjects IS NOT NULL AND NEW.subjects IS NOT OLD.subjects
    OR OLD.test_id IS NOT NULL AND NEW.test_id IS NOT OLD.test_id)
BEGIN
    SELECT RAISE(IGNORE);
END;
