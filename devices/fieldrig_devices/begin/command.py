"""`fieldrig new`: creates a folder to start from: one of the examples, or a rig for an EDS file or a register list."""

import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

from fieldrig.cli.common import writing
from fieldrig.errors import UsageError

SECTION = "Files"
"""The group of the command in the help of `fieldrig`."""
MOST_NAMED = 20
"""Files that are named."""
Content = Mapping[PurePosixPath, bytes]


def complete_example(incomplete: str) -> list[tuple[str, str]]:
    """Return the examples with their descriptions, for completion in the shell."""
    from fieldrig_devices.begin.examples import menu

    return [(name, about) for name, about in menu().items() if name.startswith(incomplete)]


def new(
    example: Annotated[
        str | None,
        typer.Argument(
            metavar="[EXAMPLE]",
            help="The example; omit it with --eds.",
            show_default=False,
            autocompletion=complete_example,
        ),
    ] = None,
    folder: Annotated[
        str | None,  # a Path has "" as the current folder
        typer.Argument(
            metavar="[DIR]", help="The folder to create.  [default: the name of the example]", show_default=False
        ),
    ] = None,
    eds: Annotated[
        Path | None,
        typer.Option("--eds", metavar="FILE", help="Create a rig for this EDS or DCF file.", show_default=False),
    ] = None,
    registers: Annotated[
        Path | None,
        typer.Option(
            "--registers", metavar="FILE", help="Create a rig for this CSV list of registers.", show_default=False
        ),
    ] = None,
    recording: Annotated[
        Path | None,
        typer.Option(
            "--from",
            metavar="RECORDING",
            help="Create a rig with the devices of this recording.",
            show_default=False,
        ),
    ] = None,
    described: Annotated[
        list[str] | None,
        typer.Option(
            "--with",
            metavar="[NODE=]FILE",
            help="The EDS or DCF file of a node of the recording. May be given several times.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Create a rig with its files and a passing test.

    \b
        fieldrig new                       list the examples, and ask for one
        fieldrig new lab bench             the files of the example `lab`, in the folder bench
        fieldrig new --eds drive.eds       a CANopen node from an EDS file, in the folder drive
        fieldrig new --registers meter.csv a Modbus device from a list of its registers, in the folder meter
        fieldrig new --from machine.blf    the devices that a recording shows, in the folder machine

    Existing files are never overwritten.
    """
    given = [
        name for name, file in (("--eds", eds), ("--registers", registers), ("--from", recording)) if file is not None
    ]
    for name, what in ((example, "a folder" if given else "an example"), (folder, "a folder")):
        if name is not None and not name.strip():
            raise typer.BadParameter(f"expected the name of {what}, got {name!r}; `.` is the current folder")
    if len(given) > 1:
        raise typer.BadParameter(f"expected either {' or '.join(given)}")
    if folder is not None and given:
        raise typer.BadParameter(f"expected only the folder with {given[0]}, and no example")
    if described and recording is None:
        raise typer.BadParameter("--with goes with --from: it describes a node of a recording")
    if registers is not None:
        _from_list(registers, example)
    elif eds is not None:
        _from_eds(eds, example)
    elif recording is not None:
        _from_recording(recording, described or (), example)
    else:
        _from_menu(example, Path(folder) if folder is not None else None)


def _from_eds(eds: Path, folder: str | None) -> None:
    from fieldrig.text.device_names import name_for
    from fieldrig_devices.begin.eds_rig import content_for, note_for

    _make(content_for(eds), Path(folder or name_for(eds)))
    if note := note_for(eds):
        typer.echo(f"\n{note}")


def _from_recording(recording: Path, described: Sequence[str], folder: str | None) -> None:
    from fieldrig.text.device_names import name_for
    from fieldrig_devices.from_recording.content import content_for

    content, notes, without = content_for(recording, described)
    made = Path(folder or name_for(recording))
    _make(content, made)
    left_out = [word for bus in without for word in ("--leave-out", bus)]
    words = ("fieldrig", "replay", str(recording), "--rig", str(made / next(iter(content))), *left_out)
    typer.echo(f"  {shlex.join(words)}")
    if notes:
        typer.echo("\n" + "\n".join(f"note: {note}" for note in notes))


def _from_list(registers: Path, folder: str | None) -> None:
    from fieldrig.text.device_names import name_for
    from fieldrig_devices.begin.register_rig import content_for

    content, notes = content_for(registers)
    _make(content, Path(folder or name_for(registers)))
    if notes:
        typer.echo("\n" + "\n".join(f"note: {note}" for note in notes))


def _from_menu(example: str | None, folder: Path | None) -> None:
    from fieldrig.text.nearest import closest
    from fieldrig_devices.begin.examples import content_of, menu

    examples = menu()
    if example is None:
        _show(examples)
        if not (sys.stdin.isatty() and sys.stdout.isatty()):
            typer.echo("\n`fieldrig new EXAMPLE [DIR]` copies an example, `fieldrig new --eds FILE` creates a node")
            return
        example = typer.prompt("\nExample", default="lab")
        folder = Path(typer.prompt("Folder", default=example))
    if example not in examples:
        is_eds = Path(example).suffix.lower() in (".eds", ".dcf")
        remedy = f"write `fieldrig new --eds {example}`" if is_eds else closest(example, list(examples))
        raise UsageError(f"there is no example {example!r}", remedy)
    _make(content_of(example), folder or Path(example))


def _show(examples: Mapping[str, str]) -> None:
    from fieldrig.cli.common import echo_table

    echo_table(("example", "what it is"), examples.items())


def _make(content: Content, folder: Path) -> None:
    """Write all the files, or none if another file is in the place of one."""
    with writing(folder, "name another folder"):
        taken = [str(path) for path, data in content.items() if _is_taken(folder / path, data)]
        if taken:
            raise UsageError(f"{folder} already has other files named {', '.join(taken)}", "name another folder")
        if folder.exists():
            _write(content, folder, folder)
        else:
            _write_whole(content, folder)
    _tell(content, folder)


def _write_whole(content: Content, folder: Path) -> None:
    """Write a new folder beside its place, and put it there at the end: a full disk leaves no half of it."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}.") as beside:
        _write(content, Path(beside, folder.name), folder)
        Path(beside, folder.name).rename(folder)


def _write(content: Content, folder: Path, target: Path) -> None:
    """Write the files into a folder that is, or will be, `target`, by whose name messages call it."""
    for path, data in content.items():
        file = folder / path
        if not file.exists():
            with writing(target / path, "name another folder"):
                file.parent.mkdir(parents=True, exist_ok=True)
                with file.open("xb") as opened:
                    opened.write(data)


def _is_taken(file: Path, data: bytes) -> bool:
    """True if writing the file would change something that already exists."""
    if file.exists() or file.is_symlink():
        return not file.is_file() or file.read_bytes() != data
    return any(parent.exists() and not parent.is_dir() for parent in file.parents)


def _some(words: list[str]) -> str:
    """Return the first words of many, and how many there are besides."""
    more = len(words) - MOST_NAMED
    return ", ".join(words[:MOST_NAMED]) + (f" and {more} more" if more > 0 else "")


def _tell(content: Content, folder: Path) -> None:
    from importlib.util import find_spec

    rig = shlex.quote(str(folder / next(iter(content))))
    typer.echo(f"{folder}: {_some(list(map(str, content)))}\n\nnext:")
    typer.echo(f"  fieldrig check {rig}")
    typer.echo(f"  fieldrig up {rig}")
    hint = "" if find_spec("pytest") else "    # after: python -m pip install pytest"
    typer.echo(f"  python -m pytest {shlex.quote(str(folder))}{hint}")
