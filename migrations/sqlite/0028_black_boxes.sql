-- Black boxes: the messages of a robot around a trim, a fault or an alarm.

-- A box begins at least a minute before its event and ends a minute after the last event in it, if `black_box.seconds` is 60.
-- `cause`: TRIM, or the kind of fault or alarm of the first event. `event_us`: its time. `began_us`: time from which on all
-- messages are in the box. `ends_us`: planned end. `last_us`: time of the newest message. All by the supervisor's clock.
-- `state`: RECORDING has the messages before the event and will be replaced; COMPLETE has everything; PARTIAL lacks messages,
-- because the supervisor stopped or had just started, or because the robot sent more than memory is reserved for.
-- `left_out`: messages that the limit of memory left out after the event. `has_state`: it begins with the robot's state.
-- `body`: the lines of a recording, compressed (gzip); `bytes`: their size.
CREATE TABLE black_boxes (
    black_box_id INTEGER PRIMARY KEY AUTOINCREMENT,
    robot_id     INTEGER NOT NULL REFERENCES robots,
    whisker_id   INTEGER NOT NULL REFERENCES whiskers,
    cause        TEXT    NOT NULL,
    event_us     INTEGER NOT NULL,
    began_us     INTEGER NOT NULL,
    ends_us      INTEGER NOT NULL,
    last_us      INTEGER NOT NULL,
    state        TEXT    NOT NULL CHECK (state IN ('RECORDING', 'COMPLETE', 'PARTIAL')),
    messages     INTEGER NOT NULL,
    left_out     INTEGER NOT NULL,
    has_state    INTEGER NOT NULL,
    bytes        INTEGER NOT NULL,
    body         BLOB    NOT NULL,
    UNIQUE (robot_id, event_us)
);
CREATE INDEX black_boxes_recording ON black_boxes (robot_id) WHERE state = 'RECORDING';
CREATE INDEX black_boxes_by_time ON black_boxes (event_us);
