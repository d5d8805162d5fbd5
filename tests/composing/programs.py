"""Programs that the Dockerfile builds. Everything that stands in for its build reads them here."""

import re
from pathlib import Path

PROJECT = Path(__file__).parent.parent.parent


def builds():
    """Arguments of each `cargo build` of the Dockerfile, after `build`."""
    text = (PROJECT / "Dockerfile").read_text().replace("\\\n", " ")
    commands = re.findall(r"\bcargo build (.*?)(?:&&|\n)", text)
    if not commands:
        raise RuntimeError("Dockerfile: no call of cargo build")
    return [command.split() for command in commands]


def programs():
    """Names of the programs, which are those of their packages."""
    return [after for arguments in builds() for before, after in zip(arguments, arguments[1:]) if before == "-p"]
