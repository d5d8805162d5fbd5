-- The error of the air alone, without the gain on the readings, with its 95 % interval. NULL where the robot applies no
-- gain, so that `error` is that of the air alone, and in rows of before.
ALTER TABLE compensation_errors ADD COLUMN air_error REAL;
ALTER TABLE compensation_errors ADD COLUMN air_error_low REAL;
ALTER TABLE compensation_errors ADD COLUMN air_error_high REAL;
