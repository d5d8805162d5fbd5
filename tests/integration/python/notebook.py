"""Runs a notebook, and writes its pictures into a folder: `notebook.py FILE FOLDER`."""

import base64
import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

notebook = nbformat.read(sys.argv[1], as_version=4)
NotebookClient(notebook, timeout=60, kernel_name="python3").execute()
pictures = [
    output["data"]["image/png"]
    for cell in notebook.cells
    for output in cell.get("outputs", [])
    if "image/png" in output.get("data", {})
]
for number, picture in enumerate(pictures, 1):
    Path(sys.argv[2], f"curve-{number}.png").write_bytes(base64.b64decode(picture))
print(f"{len(pictures)} pictures")
