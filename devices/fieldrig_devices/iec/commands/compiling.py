"""Compiling for a command: alone, or for a controller of a rig file."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig_devices.iec.commands.sources import dialect_named

if TYPE_CHECKING:
    from fieldrig_devices.iec.compiler import Compiled
    from fieldrig_devices.iec.controller.holder import ProgramHolder
    from fieldrig_devices.languages.source_file import SourceFile

RigOption = Annotated[
    Path | None,
    typer.Option(
        "--rig",
        metavar="FILE",
        help="Compile for a controller of this rig file, with its objects, libraries and dialect.",
        exists=True,
        dir_okay=False,
        show_default=False,
    ),
]
DeviceOption = Annotated[
    str | None,
    typer.Option("--device", metavar="NAME", help="The controller, if the rig has several.", show_default=False),
]


def compiled(
    sources: "Sequence[SourceFile]", dialect: str, rig: Path | None, device: str | None, resource: str = ""
) -> "Compiled":
    """Compile a program.  CompileError with every mistake; ConfigError for a wrong rig file."""
    from fieldrig.clock import VirtualClock
    from fieldrig_devices.iec.compiler import compile_project
    from fieldrig_devices.iec.standalone import StandaloneHost
    from fieldrig_devices.iec.testing.gathered import with_files_to_give
    from fieldrig_devices.languages.mistakes import CompileError

    rules = dialect_named(dialect)
    if rig is not None and resource:
        raise typer.BadParameter("--resource does not go with --rig, whose controller has the key resource")
    if rig is not None:
        return _holder(rig, device).compile_sources(sources)
    if device is not None:
        raise typer.BadParameter("--device needs --rig FILE")
    try:
        return compile_project(sources, StandaloneHost(VirtualClock()), rules, resource=resource)
    except CompileError as wrong:
        told = with_files_to_give(wrong.mistakes, [Path(source.name) for source in sources], rules)
        raise CompileError(told) from wrong


def _holder(rig: Path, device: str | None) -> "ProgramHolder":
    """Build the controller by itself.  The program that the rig file names may be wrong, and is left out."""
    from fieldrig.config.build import build_alone
    from fieldrig.config.rig_file import look_through
    from fieldrig.errors import ConfigError, UsageError
    from fieldrig.text.nearest import closest
    from fieldrig_devices.iec.controller.holder import ProgramHolder

    _, right, mistakes = look_through(rig)
    chosen = [entry for entry in right if issubclass(entry.cls, ProgramHolder) and device in (None, entry.name)]
    if len(chosen) != 1:
        if mistakes:
            raise ConfigError(mistakes)
        known = [entry.name for entry in right if issubclass(entry.cls, ProgramHolder)]
        if not known:
            raise UsageError(f"none of the devices of {rig} runs IEC programs", "name another rig file")
        if device is not None:
            raise UsageError(f"{rig} has no controller {device!r}", closest(device, known))
        raise UsageError(f"{rig} has several controllers", f"expected --device with one of: {', '.join(known)}")
    entry = chosen[0]
    assert issubclass(entry.cls, ProgramHolder)
    _, right, mistakes = look_through(rig, [f"devices.{entry.name}.{change}" for change in entry.cls.without_program()])
    for changed in right:
        if changed.name == entry.name:
            holder = build_alone(changed)
            assert isinstance(holder, ProgramHolder)
            return holder
    raise ConfigError(mistakes)
