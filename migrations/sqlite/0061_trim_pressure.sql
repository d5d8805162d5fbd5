-- Pressure of the whisker at the detection, MPa. NULL if it was detected by an earlier version, or if no pressure was known.
ALTER TABLE trims ADD COLUMN pressure_mpa REAL;
