-- The objective SHAPE: air for the shape over the contact ratio, and a gain on the readings for the level. Robots whose
-- factsheet does not say applies_gain have TIP instead.
ALTER TABLE policies DROP CONSTRAINT policies_objective_check;
ALTER TABLE policies ADD CONSTRAINT policies_objective_check CHECK (objective IN ('TIP', 'MEAN', 'SHAPE'));
