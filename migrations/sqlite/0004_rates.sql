-- How fast a whisker leaks and erodes, each with a 95 % interval. NULL where it cannot be told (yet).

-- `leak_*_per_s`: loss of gauge pressure while it is held, per second and relative to itself.
-- `erosion_*_mm_per_contact`: loss of length with each contact, while the whisker erodes. `contacts_left*`: contacts
-- until it is shorter than what can compensate for itself at 0 MPa; the upper bound is NULL if it may not erode at all.
ALTER TABLE whiskers ADD COLUMN leak_per_s REAL;
ALTER TABLE whiskers ADD COLUMN leak_low_per_s REAL;
ALTER TABLE whiskers ADD COLUMN leak_high_per_s REAL;
ALTER TABLE whiskers ADD COLUMN erosion_mm_per_contact REAL;
ALTER TABLE whiskers ADD COLUMN erosion_low_mm_per_contact REAL;
ALTER TABLE whiskers ADD COLUMN erosion_high_mm_per_contact REAL;
ALTER TABLE whiskers ADD COLUMN contacts_left REAL;
ALTER TABLE whiskers ADD COLUMN contacts_left_low REAL;
ALTER TABLE whiskers ADD COLUMN contacts_left_high REAL;
