#!/usr/bin/env python3
"""Checks that every panel of a dashboard is described, has a unit, and shows something.

    dashboards/check.py http://127.0.0.1:9090 [minutes]

The address is that of a Prometheus which has scraped a supervisor with compensations (vibrissa demo --serve) in
the last minutes, 5 unless told. Each expression is asked for as Grafana would, with all jobs and instances.
"""

import json
import math
import pathlib
import sys
import time
import urllib.parse
import urllib.request

STEP_S = 5


def points(prometheus, expression, minutes, instant):
    """How many finite samples an expression gives."""
    values = {"$__rate_interval": "20s", "$__range": f"{minutes}m", "$job": ".*", "$instance": ".*"}
    for name, value in values.items():
        expression = expression.replace(name, value)
    now = time.time()
    span = {"time": now} if instant else {"start": now - 60 * minutes, "end": now, "step": STEP_S}
    query = urllib.parse.urlencode({"query": expression, **span})
    with urllib.request.urlopen(f"{prometheus}/api/v1/query{'' if instant else '_range'}?{query}") as response:
        series = json.load(response)["data"]["result"]
    samples = [sample for one in series for sample in one.get("values", [one.get("value")])]
    return len(series), sum(math.isfinite(float(value)) for _, value in samples)


def main(prometheus, minutes="5"):
    problems = []
    for file in sorted(pathlib.Path(__file__).parent.glob("*.json")):
        for panel in json.loads(file.read_text(encoding="utf-8"))["panels"]:
            if panel["type"] == "row":
                continue
            title = f"{file.name}: {panel['title']}"
            if not panel.get("description") or not panel["fieldConfig"]["defaults"].get("unit"):
                problems.append(f"{title}: has no description or no unit")
            for target in panel["targets"]:
                series, finite = points(prometheus, target["expr"], int(minutes), target.get("instant", False))
                print(f"{finite:6} points in {series:2} series  {title}, {target['refId']} {target['legendFormat']}")
                if finite == 0:
                    problems.append(f"{title}: nothing for {target['expr']}")
    print("\n".join(problems) or "Every panel shows something.")
    return bool(problems)


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
