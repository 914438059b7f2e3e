"""Terminal sessions: commands of fieldrig with what they print."""

import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from tests.pictures.recording import ROOT
from tests.pictures.terminal import terminal

LONGEST: Final = 120

FIVE: Final = """\
time: reel
buses:
  can0: {kind: can.hubb, bitrate: 250000}
  mb: {kind: modbus.tcp, listen: 5020}
devices:
  io: {kind: canopen.node, node_id: 200, eds: eds/none.eds, links: {can: can1}}
"""


def session(command: str, title: str, about: str) -> str:
    """A command in the root of a clone and its output."""
    return terminal([f"$ {command}", *output_of(command)], title, about)


def output_of(command: str, folder: Path = ROOT) -> list[str]:
    """The lines that a command of fieldrig prints in a folder."""
    result = subprocess.run(
        [str(Path(sys.executable).parent / "fieldrig"), *command.split()[1:]],
        cwd=folder,
        env={**os.environ, "COLUMNS": str(LONGEST), "NO_COLOR": "1"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return [line.rstrip() for line in result.stdout.splitlines()]


def mistakes() -> str:
    """`fieldrig check` on a rig file with several mistakes."""
    with TemporaryDirectory() as folder:
        (Path(folder) / "five.yaml").write_text(FIVE, encoding="utf-8")
        lines = output_of("fieldrig check five.yaml", Path(folder))
    about = "Each mistake has its file, line and key, and a second line tells what was expected."
    return terminal(
        ["$ fieldrig check five.yaml", *(line.replace(f"{folder}/", "") for line in lines)],
        "fieldrig check reports all mistakes at once",
        about,
    )


PICTURES: Final[Mapping[str, Callable[[], str]]] = {
    "check-mistakes": mistakes,
    "new-menu": partial(
        session, "fieldrig new", "The menu of examples", "A list of the examples, each with one line of description."
    ),
}
