"""The command `trace dissector`: Wireshark shows our own messages by it."""

import shutil
from pathlib import Path
from typing import Annotated, Final

import typer

from fieldrig.cli.common import writing

DISSECTOR: Final = Path(__file__).with_name("dissector.lua")
NAME: Final = "fieldrig.lua"


def dissector(
    folder: Annotated[
        Path | None,
        typer.Option(
            "--install",
            metavar="FOLDER",
            help="Copy it into this folder, such as the Personal Lua Plugins that Wireshark lists under Help, About.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Print the path of the Wireshark dissector for messages without a standard format.

    \b
        tshark -X lua_script:$(fieldrig trace dissector) -r lab.pcapng
        fieldrig trace dissector --install ~/.local/lib/wireshark/plugins
    """
    if folder is None:
        typer.echo(DISSECTOR)
        return
    target = folder / NAME
    with writing(target):
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(DISSECTOR, target)
    typer.echo(f"{target}: Wireshark reads it at its next start", err=True)
