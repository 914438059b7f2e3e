"""Mistakes of the rigs that tests name, as far as their rig files tell: a boot would tell the rest."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from fieldrig.errors import RigError
from fieldrig.points.names import split_point
from fieldrig.text.nearest import closest
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.testing.extension import CaseBlock
from fieldrig_devices.iec.testing.in_rig import after_ns, rig_file
from fieldrig_devices.languages.mistakes import Mistake


def mistakes_of_rigs(test: Path, unit: tree.Unit, blocks: Sequence[CaseBlock]) -> list[Mistake]:
    """Return what is wrong with the rigs of the tests in a file, and with the devices and buses behind AT."""
    declared = {one.name: one.position for part in unit.tests for block in part.blocks for one in block.variables}
    known: dict[str, Sequence[str]] = {}
    found: dict[Mistake, None] = {}
    for block in blocks:
        if block.file == str(test) and block.rig is not None:
            found.update(dict.fromkeys(_of_block(test, block.rig, block.places, known, declared)))
    return list(found)


def _of_block(
    test: Path,
    use: tree.RigUse,
    places: Mapping[str, str],
    known: dict[str, Sequence[str]],
    declared: Mapping[str, tree.Position],
) -> Iterator[Mistake]:
    try:
        after_ns(use)
        if use.file not in known:
            known[use.file] = _parts(rig_file(test.parent, use))
    except RigError as wrong:
        yield Mistake(*use.position, wrong.what, wrong.remedy.removeprefix("expected "), file=str(test))
        return
    for name, place in places.items():
        part, _ = split_point(place)
        if part not in known[use.file]:
            what = f"{name} is at {place!r}, and {use.file} has no {part!r}"
            hint = closest(part, known[use.file])
            yield Mistake(*declared[name], what, "a device or a bus in front of the /", file=str(test), hint=hint)


def _parts(file: Path) -> Sequence[str]:
    """Return the names of the devices and buses of a rig file.  ConfigError for a wrong one."""
    from fieldrig.config.rig_file import load

    config = load(file, ("time=virtual",))
    return [*config.devices, *config.buses]
