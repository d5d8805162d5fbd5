"""Queries of the dashboard of one whisker. They read contacts by the index on whisker number and time."""

from . import rows
from .rows import WHISKER_ID, between, bucket, time

# Compensations with this whisker as target or as compensator.
ITS = f"(c.target_whisker_id = {WHISKER_ID} OR c.compensator_whisker_id = {WHISKER_ID})"
OF_CONTACTS = f"FROM contacts c WHERE c.whisker_id = {WHISKER_ID} AND {between('c.t_us')}"

# One of three: for spans of days the minutes, for months the hours, which remain after contacts have been removed.
LENGTHS = f"""
    SELECT c.t_us AS us, c.length_mm, c.length_sd_mm, 1 AS contacts
    {OF_CONTACTS} AND $__interval_ms < 60000
    UNION ALL SELECT m.start_us, m.length_mean_mm, m.length_sd_mm,
        m.contacts_used + m.contacts_learning + m.contacts_unused
    FROM contact_minutes m WHERE m.whisker_id = {WHISKER_ID} AND {between("m.start_us")}
        AND m.length_mm IS NOT NULL AND $__interval_ms BETWEEN 60000 AND 3599999
    UNION ALL SELECT h.start_us, h.length_mean_mm, h.length_sd_mm,
        h.contacts_used + h.contacts_learning + h.contacts_unused
    FROM contact_hours h WHERE h.whisker_id = {WHISKER_ID} AND {between("h.start_us")}
        AND h.length_mm IS NOT NULL AND $__interval_ms >= 3600000
"""

LENGTH = f"""
    SELECT {bucket("l.us")} AS "time", sum(l.length_mm * l.contacts) / sum(l.contacts) AS length,
        sum((l.length_mm - {rows.Z95} * l.length_sd_mm) * l.contacts) / sum(l.contacts) AS low,
        sum((l.length_mm + {rows.Z95} * l.length_sd_mm) * l.contacts) / sum(l.contacts) AS high
    FROM ({LENGTHS}) l GROUP BY 1 ORDER BY 1
"""

# The interval of the mean; a single contact has no interval.
RESIDUAL = f"""
    SELECT "time", exp(mean) AS "measured over predicted",
        exp(mean - {rows.Z95} * error) AS low, exp(mean + {rows.Z95} * error) AS high
    FROM (
        SELECT {bucket("c.t_us")} AS "time", avg(c.residual) AS mean, stddev_samp(c.residual) / sqrt(count(*)) AS error
        {OF_CONTACTS} AND c.residual IS NOT NULL GROUP BY 1
    ) binned ORDER BY 1
"""

HEALTH = f"""
    SELECT {time("s.us")} AS "time", s.state AS health FROM ({rows.health(WHISKER_ID)}) s ORDER BY s.us
"""

USE = f"""
    SELECT {bucket("c.t_us")} AS "time", c.used AS metric, count(*) AS contacts
    {OF_CONTACTS} GROUP BY 1, 2 ORDER BY 1, 2
"""

PRESSURE = f"""
    SELECT {bucket("c.t_us")} AS "time", 1e6 * avg(c.pressure_mpa) AS measured {OF_CONTACTS} GROUP BY 1 ORDER BY 1
"""

ISSUED = f"SELECT s.issued_us AS us, s.pressure_mpa AS state FROM setpoints s WHERE s.whisker_id = {WHISKER_ID}"
NOMINAL = f"(SELECT x.nominal_pressure_mpa FROM whiskers x WHERE x.whisker_id = {WHISKER_ID})"
SETPOINT = f"""
    SELECT {time("p.us")} AS "time", 1e6 * p.state AS setpoint FROM ({rows.steps(ISSUED, NOMINAL)}) p ORDER BY p.us
"""

SENSITIVITY = f"""
    SELECT to_char(round(c.ratio::numeric / 0.05) * 0.05, 'FM0.00') AS "contact ratio",
        avg(c.strain / c.deflection_mm) AS "strain per mm"
    {OF_CONTACTS} AND c.deflection_mm > 0 GROUP BY 1 ORDER BY 1
"""

NEWEST_ERROR = f"""
    SELECT e.error FROM compensations c JOIN compensation_errors e USING (compensation_id)
    WHERE {ITS} AND c.ended_us IS NULL ORDER BY e.recorded_us DESC LIMIT 1
"""

ERROR = f"""
    SELECT {time("e.recorded_us")} AS "time", e.error AS measured, e.error_low AS low, e.error_high AS high,
        e.error_with_gain AS "with gain", c.predicted_error AS predicted
    FROM compensations c JOIN compensation_errors e USING (compensation_id)
    WHERE {ITS} AND {between("e.recorded_us")} ORDER BY e.recorded_us
"""

BY_RATIO = f"""
    SELECT to_char(b.ratio, 'FM0.00') AS "contact ratio", b.error AS measured, b.error_low AS low, b.error_high AS high,
        p.predicted
    FROM (
        SELECT e.compensation_id, e.compensation_error_id
        FROM compensations c JOIN compensation_errors e USING (compensation_id)
        WHERE {ITS} AND {between("e.recorded_us")} ORDER BY e.recorded_us DESC LIMIT 1
    ) e
    JOIN compensation_error_bins b USING (compensation_error_id)
    {rows.PREDICTED_AT_RATIO.strip()}
    ORDER BY b.ratio
"""

CANDIDATES = f"""
    SELECT {time("c.decided_us")} AS decided, r.fleet, r.robot, a."array", w.whisker AS candidate, k.chosen, k.refused,
        k.compensation_case AS "case", k.length_mm AS length, 1e6 * k.pressure_before_mpa AS before,
        1e6 * k.pressure_mpa AS pressure,
        k.predicted_error AS predicted, k.predicted_error_low AS low, k.predicted_error_high AS high,
        k.gives_up_own_role AS "gives up its own", c.approval, {time("c.ended_us")} AS ended,
        c.end_reason AS "end reason"
    FROM compensations c JOIN compensation_candidates k USING (compensation_id)
    {rows.OF_WHISKER}
    WHERE c.target_whisker_id = {WHISKER_ID} AND (c.ended_us IS NULL OR {between("c.decided_us")})
    ORDER BY c.decided_us DESC, k.ordinal LIMIT 200
"""

TRIMS = f"""
    SELECT {time("t.detected_us")} AS found, t.length_before_mm AS before, t.length_after_mm AS after,
        {rows.Z95} * t.length_after_sd_mm AS "+-", t.contacts_to_detect AS contacts
    FROM trims t WHERE t.whisker_id = {WHISKER_ID} AND {between("t.detected_us")} ORDER BY t.detected_us DESC LIMIT 200
"""

SETPOINTS = f"""
    SELECT {time("h.recorded_us")} AS heard, s.reason, 1e6 * s.pressure_mpa AS pressure, h.state, h.error,
        1e6 * h.pressure_mpa AS reached, {time("s.issued_us")} AS issued, s.epoch, s.version
    FROM setpoints s JOIN setpoint_states h USING (command_id)
    WHERE s.whisker_id = {WHISKER_ID} AND {between("s.issued_us")}
    ORDER BY s.issued_us DESC, h.setpoint_state_id DESC LIMIT 200
"""

REFINEMENTS = f"""
    SELECT {time("f.recorded_us")} AS reviewed, f.outcome, f.contacts, 1e6 * f.pressure_from_mpa AS pressure,
        1e6 * f.pressure_best_mpa AS best, f.error, f.error_best AS expected, f.error_with_gain AS "with gain",
        f.gain_published AS "new gain"
    FROM compensations c JOIN compensation_refinements f USING (compensation_id)
    WHERE {ITS} AND {between("f.recorded_us")} ORDER BY f.recorded_us DESC LIMIT 200
"""

ALARMS = f"""
    SELECT o.kind, {time("o.raised_us")} AS raised, {time("o.cleared_us")} AS over,
        o.acknowledged_by AS "acknowledged by"
    FROM alarms o WHERE o.whisker_id = {WHISKER_ID} AND (o.cleared_us IS NULL OR {between("o.raised_us")})
    ORDER BY o.raised_us DESC LIMIT 200
"""
