-- State of a whisker's segmenter by the newest status, such as LEARNING. NULL if the robot states none: it finds contacts in
-- another way than from samples of strain, or does not know.
ALTER TABLE whiskers ADD COLUMN segmenter TEXT;
-- Programs of a robot by its newest factsheet: a JSON list of objects with kind, name and version.
ALTER TABLE robots ADD COLUMN software TEXT NOT NULL DEFAULT '[]';
