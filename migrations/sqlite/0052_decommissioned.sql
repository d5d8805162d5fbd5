-- Time at which a robot was decommissioned, by the supervisor's clock; NULL for a robot in service. A decommissioned robot
-- is in no list. Its history stays, and its next boot is registered anew under the same number.
ALTER TABLE robots ADD COLUMN decommissioned_us INTEGER;
