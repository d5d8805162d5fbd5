"""Programs that the Dockerfile builds. Everything that stands in for its build reads them here."""

import re
from pathlib import Path

PROJECT = Path(__file__).parent.parent.parent


def build_arguments():
    """Arguments of the Dockerfile's `cargo build`, after `build`."""
    text = (PROJECT / "Dockerfile").read_text().replace("\\\n", " ")
    commands = re.findall(r"\bcargo build (.*?)(?:&&|\n)", text)
    if len(commands) != 1:
        raise RuntimeError(f"Dockerfile: {len(commands)} calls of cargo build instead of one")
    return commands[0].split()


def programs():
    """Names of the programs, which are those of their packages."""
    arguments = build_arguments()
    return [after for before, after in zip(arguments, arguments[1:]) if before == "-p"]
