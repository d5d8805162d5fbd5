-- A failover of the database can lose the transaction that assigned a number to a robot, boot or whisker. Its owner counts
-- such transactions, to notice the loss before a later one refers to the number.

-- Number of transactions in this epoch that assigned numbers.
ALTER TABLE leases ADD COLUMN numbers BIGINT NOT NULL DEFAULT 0;
