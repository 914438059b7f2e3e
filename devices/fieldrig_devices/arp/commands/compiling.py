"""The command `fieldrig arp compile`."""

from pathlib import Path
from typing import Annotated

import typer

from fieldrig.cli.common import writing
from fieldrig.system.exits import Exit
from fieldrig_devices.arp.commands.checking import read_text


def compile_(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Source file, NAME.Inn.", show_default=False)],
    system: Annotated[
        int | None,
        typer.Option(help="Address nn of the card, if the file name does not contain it.", show_default=False),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Output folder.  [default: the folder of the source]", show_default=False),
    ] = None,
) -> None:
    """Compile a program, or list all its mistakes.

    \b
    cam.I01 becomes cam.D01 (object), .E01 (mistakes), .M01 (map), .O01 (binary object), .S01 (symbols).
    With mistakes only .E01 is written, and objects of earlier compilations are removed.
        fieldrig arp compile cam.I01
        fieldrig arp compile cam.txt --system 1 --out build
    """
    from fieldrig_devices.arp.language.compiler import compile_text
    from fieldrig_devices.arp.language.files import HIGHEST_SYSTEM, failed, outputs, system_of
    from fieldrig_devices.languages.mistakes import CompileError

    named = system_of(file)
    address = named if system is None else system
    if address is None or not 0 <= address <= HIGHEST_SYSTEM:
        raise typer.BadParameter(
            f"no card address; name the file {file.stem}.I01, or give --system 0 to {HIGHEST_SYSTEM}"
        )
    if named is not None and named != address:
        raise typer.BadParameter(f"{file.name} is for system {named:02}, not {address:02}")
    text = read_text(file)
    folder = out or file.parent
    try:
        compiled = compile_text(text)
    except CompileError as wrong:
        _write(folder, file.stem, address, failed(wrong))
        for mistake in wrong.mistakes:
            typer.echo(f"{file}:{mistake}", err=True)
        raise typer.Exit(Exit.WRONG) from wrong
    for note in compiled.notes:
        typer.echo(f"{file}:{note}")
    written = outputs(compiled, file.stem, address)
    if named is None or folder != file.parent:
        written = {"I": text.encode(), **written}
    _write(folder, file.stem, address, written)
    names = ", ".join(f"{file.stem}.{letter}{address:02}" for letter in written)
    typer.echo(f"written to {folder}: {names}")


def _write(folder: Path, name: str, system: int, contents: dict[str, bytes]) -> None:
    """Write these files, and remove those that an earlier compilation left."""
    from fieldrig.system.whole_file import replace_file

    with writing(folder):
        for letter in "DEMOS":
            if letter not in contents:
                (folder / f"{name}.{letter}{system:02}").unlink(missing_ok=True)
        for letter, content in contents.items():
            replace_file(folder / f"{name}.{letter}{system:02}", content)
