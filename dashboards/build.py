#!/usr/bin/env python3
"""Generates the dashboards in this folder from `source`.

    dashboards/build.py           writes them
    dashboards/build.py --check   lists those that are out of date, and fails if there are any

Needs Grafana's SDK: pip install -r dashboards/requirements-dashboards.txt. Grafana reads the generated files, so they
are committed.
"""

import json
import pathlib
import sys

# No __pycache__ beside the sources.
sys.dont_write_bytecode = True

from grafana_foundation_sdk.cog.encoder import JSONEncoder

from source import compensation, fleet, robot, supervisor, whisker

DASHBOARDS = [fleet, compensation, robot, whisker, supervisor]


def main(arguments):
    if arguments not in ([], ["--check"]):
        sys.exit(__doc__)
    folder = pathlib.Path(__file__).parent
    texts = {f"{one.NAME}.json": written(one.dashboard()) for one in DASHBOARDS}
    stale = [name for name, text in texts.items() if not is_same(folder / name, text)]
    stale += [file.name for file in folder.glob("*.json") if file.name not in texts]
    if arguments:
        print("\n".join(f"{name} is out of date: run dashboards/build.py" for name in stale), end="")
        return bool(stale)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    return False


def written(dashboard):
    return json.dumps(dashboard, cls=JSONEncoder, indent=2, ensure_ascii=False) + "\n"


def is_same(file, text):
    return file.is_file() and file.read_text(encoding="utf-8") == text


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
