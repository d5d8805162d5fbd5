-- Notes that operators write on robots.

-- A robot has at most 100 notes. `author`: person or token that wrote it. `text`: 1 to 2000 characters.
-- `action_id`: entry of the audit log that added it, by which a repeated request finds it.
CREATE TABLE notes (
    note_id    BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    robot_id   BIGINT NOT NULL REFERENCES robots,
    written_us BIGINT NOT NULL,
    author     TEXT   NOT NULL,
    text       TEXT   NOT NULL,
    action_id  BIGINT NOT NULL UNIQUE REFERENCES actions
);
CREATE INDEX notes_of_robot ON notes (robot_id, note_id);
