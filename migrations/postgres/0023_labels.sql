-- Labels that operators put on robots: each line is key=value, in the order of the keys. A robot has few, so they are in its row.
ALTER TABLE robots ADD COLUMN labels TEXT NOT NULL DEFAULT '';
