"""The planted bugs: copies of shipped programs, or of a Python master, with a mistake that an engineer might have made.

Each is a file in `planted`: what is wrong (`about`), the lines of the shipped program that are replaced (`patch`), the
plan of a search, a scenario by hand that shows the bug (`trigger`, actions beside those of the plan), and the property
that it breaks.  The shipped program itself has to be clean under the same plan, whatever a search does.

They were written before the search was tuned for them, and the first seven without knowledge of the search: the history
of the files shows which.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from shutil import copytree
from typing import Any, NamedTuple

from ruamel.yaml import YAML

from fieldrig.text.durations import duration_ns

CONFIGS = Path(__file__).parents[2] / "configs"
PLANTED = Path(__file__).with_name("planted")
MASTERS = PLANTED / "masters"


class Patch(NamedTuple):
    """Lines of a shipped file, and those that replace them."""

    file: str
    old: str
    new: str

    def apply(self, folder: Path) -> None:
        """Replace the place in a copy of the file.  ValueError if the shipped file does not have it exactly once."""
        file = folder / self.file
        text = file.read_text(encoding="utf-8")
        if (found := text.count(self.old)) != 1:
            raise ValueError(f"{self.file} has {self.old!r} {found} times, expected once")
        file.write_text(text.replace(self.old, self.new), encoding="utf-8")


class PlantedBug(NamedTuple):
    name: str
    kind: str
    about: str
    """The mistake of the engineer."""
    patches: Sequence[Patch]
    plan: Mapping[str, Any]
    """The plan of a search, as in its file."""
    trigger: Sequence[Mapping[str, Any]]
    breaks: str
    """The name of the property."""

    @property
    def master(self) -> str | None:
        """The file of the Python master that has the bug; otherwise a program of the rig has it."""
        return self.plan.get("master")

    def plan_in(self, folder: Path, *, clean: bool = False) -> Path:
        """Write a copy of all rigs with the bug, or without it, and return the file of the plan in it."""
        self._copy_to(folder, clean=clean)
        return _written(folder / "plan.yaml", self.plan)

    def scenario_in(self, folder: Path, *, clean: bool = False) -> Path:
        """Write a copy of all rigs with the bug, or without it, and return the file of the scenario by hand in it."""
        self._copy_to(folder, clean=clean)
        given = {key: value for key, value in self.plan.items() if key not in ("vary", "states", "edges")}
        steps = sorted([*self.plan.get("steps", ()), *self.trigger], key=lambda step: duration_ns(step["at"]))
        return _written(folder / "scenario.yaml", {**given, "steps": steps})

    def _copy_to(self, folder: Path, *, clean: bool) -> None:
        copytree(CONFIGS, folder, dirs_exist_ok=True)
        copytree(MASTERS, folder, dirs_exist_ok=True)
        for patch in () if clean else self.patches:
            patch.apply(folder)


def planted_bugs() -> list[PlantedBug]:
    """Return all planted bugs, in the order of their names."""
    return [_bug_of(file) for file in sorted(PLANTED.glob("*.yaml"))]


def _bug_of(file: Path) -> PlantedBug:
    given = YAML(typ="safe", pure=True).load(file)
    patches = [Patch(name, one["old"], one["new"]) for name, several in given["patch"].items() for one in several]
    return PlantedBug(
        file.stem, given["kind"], given["about"], patches, given["plan"], given["trigger"], given["breaks"]
    )


def _written(file: Path, given: Mapping[str, Any]) -> Path:
    file.write_text(json.dumps(dict(given)), encoding="utf-8")  # which is YAML as well
    return file
