"""The files of a rig on their way to a worker on another machine.

A rig is more than its file: bases, EDS files, programs, classes of its own.  What it reads while it is loaded and built
is noted, whatever it is, so that nothing has to be listed by hand.
"""

import os
import sys
import sysconfig
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.resources import files
from importlib.util import source_from_cache
from pathlib import Path, PurePosixPath
from typing import Any, Final, NamedTuple

from fieldrig.config.rig_file import load
from fieldrig.virtual.rig import Rig
from fieldrig_devices.begin.examples import folder
from fieldrig_devices.search.plan import Plan, in_world

_noted: dict[Path, None] | None = None
"""The files that were opened for reading, while they are asked for."""


class Luggage(NamedTuple):
    """A plan with the files of its rig."""

    plan: Plan
    paths: Mapping[str, PurePosixPath]
    """The paths of what the scenario names, such as the rig file, among the files."""
    files: Mapping[PurePosixPath, bytes]

    def unpack(self, folder: Path) -> Plan:
        """Write the files into an empty folder, and return the plan with the rig file that is there."""
        for name, content in self.files.items():
            file = folder / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
        there = {name: folder / path for name, path in self.paths.items()}
        return self.plan._replace(scenario=self.plan.scenario._replace(**there))  # type: ignore[arg-type]  # the same fields


def luggage_of(plan: Plan) -> Luggage:
    """Return a plan with the files that its rig reads in all worlds, except those of Python and its packages.

    ConfigError or RigError for a rig that cannot be loaded.
    """
    scenario = plan.scenario
    named = {name: value.resolve() for name, value in scenario._asdict().items() if isinstance(value, Path)}
    with _noting_files() as read:
        for world in plan.worlds:
            Rig(load(scenario.rig, ("time=virtual", *in_world(scenario, world).overrides))).close()
    own = [*named.values(), *(file for file in read if file.is_file() and not _is_installed(file))]
    root = Path(os.path.commonpath([file.parent for file in own]))
    content = {PurePosixPath(file.relative_to(root).as_posix()): file.read_bytes() for file in dict.fromkeys(own)}
    paths = {name: PurePosixPath(file.relative_to(root).as_posix()) for name, file in named.items()}
    return Luggage(plan, paths, content)


@contextmanager
def _noting_files() -> Iterator[Mapping[Path, None]]:
    """Note the files that this process reads meanwhile, in their order."""
    global _noted
    _hook()
    _noted = {}
    try:
        yield _noted
    finally:
        _noted = None


_INSTALLED: Final = tuple(
    Path(path).resolve() for name, path in sysconfig.get_paths().items() if name in ("stdlib", "purelib", "platlib")
)
_EXAMPLES: Final = folder().resolve()


def _is_installed(file: Path) -> bool:
    """Return whether the file is there wherever fieldrig is; the examples, which a user may change, do not count."""
    ours = (Path(str(files(name))).resolve() for name in ("fieldrig", "fieldrig_bus", "fieldrig_devices"))
    places = (*_INSTALLED, *ours)
    return not file.is_relative_to(_EXAMPLES) and any(file.is_relative_to(place) for place in places)


_is_hooked: list[bool] = []


def _hook() -> None:
    if not _is_hooked:
        _is_hooked.append(True)
        sys.addaudithook(_note)


def _note(event: str, arguments: tuple[Any, ...]) -> None:
    if _noted is None or event != "open" or not isinstance(arguments[0], str):
        return
    path = Path(arguments[0])
    if path.suffix == ".pyc":
        try:
            path = Path(source_from_cache(arguments[0]))
        except ValueError:  # a name that another program has made, such as pytest
            return
    _noted[path.resolve()] = None
