-- Number of whiskers on each array now. To count the rows of `whiskers` reads the whole table, because checkpoints change them all.
ALTER TABLE arrays ADD COLUMN whiskers BIGINT NOT NULL DEFAULT 0;
UPDATE arrays SET whiskers =
    (SELECT count(*) FROM whiskers w WHERE w.array_id = arrays.array_id AND position IS NOT NULL);
