"""Set-ups of the scope as files: saved under a name, opened again, and compared with the rig that is there now.

They are in `scope/NAME.json` of the rig's run folder, and not beside the rig file: that may belong to an installed
package or be mounted for reading only, and a rig writes nothing outside its run folder.  The folder stays when the rig
ends, and a set-up is copied from one rig to another as a file.
"""

import json
import re
from collections.abc import Collection
from pathlib import Path
from typing import Final

from fieldrig.errors import ControlError, RigError
from fieldrig.outside.untrusted import LONGEST, MalformedError, read_json
from fieldrig.system.own_files import open_file, part_of
from fieldrig.system.whole_file import replace_own_file
from fieldrig.text.nearest import closest
from fieldrig_page.scope.setup import Setup, read_setup

FOLDER: Final = "scope"
NAME: Final = re.compile(r"\w(?:[\w -]{0,62}[\w-])?")
MOST_SETUPS: Final = 200
PROGRAM: Final = "program:"
"""Begins the key of a variable of a program."""


class Setups:
    """The set-ups of one rig.  Every refusal is a ControlError with its remedy."""

    def __init__(self, run: Path) -> None:
        self._run = run

    def names(self) -> list[str]:
        """The names of all set-ups, in alphabetical order."""
        folder = self._run / FOLDER
        found = [path.stem for path in folder.glob("*.json")] if folder.is_dir() else []
        return sorted((name for name in found if NAME.fullmatch(name)), key=str.casefold)

    def save(self, name: str, setup: Setup) -> None:
        """Save a set-up.  One of this name is replaced at once and as a whole."""
        path = self._path(name)
        if name not in (names := self.names()) and len(names) >= MOST_SETUPS:
            raise ControlError(f"there are {MOST_SETUPS} set-ups already", "delete one of them")
        try:
            replace_own_file(path, json.dumps(setup.as_data(), indent=1).encode())
        except OSError as cause:
            raise ControlError(
                f"{path} cannot be written: {cause.strerror}", "the set-up that was there stays"
            ) from cause

    def open(self, name: str) -> Setup:
        """Return a set-up."""
        path = self._path(name)
        try:
            with open_file(path, "rb") as file:
                data = file.read(LONGEST + 1)
        except FileNotFoundError as cause:
            raise ControlError(f"there is no set-up {name!r}", closest(name, self.names())) from cause
        except OSError as cause:
            raise ControlError(f"{path} cannot be read: {cause.strerror}") from cause
        try:
            return read_setup(read_json(data))
        except MalformedError as wrong:
            raise ControlError(f"{path} is no set-up: {wrong}", "correct or delete it") from wrong

    def delete(self, name: str) -> None:
        path = self._path(name)
        try:
            path.unlink()
        except FileNotFoundError as cause:
            raise ControlError(f"there is no set-up {name!r}", closest(name, self.names())) from cause
        except OSError as cause:
            raise ControlError(f"{path} cannot be deleted: {cause.strerror}") from cause

    def _path(self, name: str) -> Path:
        if NAME.fullmatch(name) is None:
            raise ControlError(
                f"{name[:80]!r} is no name for a set-up", "expected up to 64 letters, digits, spaces, _ and -"
            )
        try:
            return part_of(self._run, f"{FOLDER}/{name}.json")
        except OSError as cause:
            raise ControlError(f"{self._run / FOLDER} cannot be made: {cause.strerror}") from cause
        except RigError as wrong:
            raise ControlError(wrong.what, wrong.remedy) from wrong


def missing(
    setup: Setup, known: Collection[str], devices: Collection[str], buses: Collection[str]
) -> list[dict[str, str]]:
    """Return the signals of a set-up that a rig does not have, each with the nearest that it has.

    `known` are the points of its devices.  A wire that has no value yet is in no list, nor is a variable of a program,
    so these are missing only if their bus or device is.
    """
    names = sorted(known)
    return [
        {"name": name, "remedy": closest(name, names)}
        for name in setup.all_signals
        if name not in known and not _may_be(name, devices, buses)
    ]


def _may_be(name: str, devices: Collection[str], buses: Collection[str]) -> bool:
    part, _, key = name.partition("/")
    return part in buses or (part in devices and key.startswith(PROGRAM))
