LOCK TABLE redo IN ACCESS EXCLUSIVE MODE;
-- A transaction with a setpoint is written as rows at once. An earlier version has to write the rows of its own transactions
-- before: the program explains a violation of this constraint.
CREATE TABLE redo_check (transactions BIGINT NOT NULL, CONSTRAINT redo_is_empty CHECK (transactions = 0));
INSERT INTO redo_check (transactions) SELECT count(*) FROM redo;
DROP TABLE redo_check;
DROP TABLE redo;
