-- The audit log: an action that has been answered is not changed any more.

-- Two columns are written after the answer, once, and an action of a request for many that was withdrawn may turn out to be
-- done already. Any other change of an answered row is left out. The function belongs to the owner of the log, if there is
-- one: deploy/postgres/supervisor.sql.
CREATE FUNCTION keep_answered_action() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    IF OLD.state <> 'PENDING'
        AND NOT (OLD.state = 'REFUSED' AND OLD.problem LIKE 'STOPPED:%' AND NEW.state = 'DONE')
        AND (to_jsonb(NEW) - ARRAY['subjects', 'test_id'] <> to_jsonb(OLD) - ARRAY['subjects', 'test_id']
            OR NEW.subjects IS DISTINCT FROM coalesce(OLD.subjects, NEW.subjects)
            OR NEW.test_id IS DISTINCT FROM coalesce(OLD.test_id, NEW.test_id))
    THEN
        RETURN NULL;
    END IF;
    RETURN NEW;
END
$$;
CREATE TRIGGER answered_action_is_kept BEFORE UPDATE ON actions
    FOR EACH ROW EXECUTE FUNCTION keep_answered_action();
