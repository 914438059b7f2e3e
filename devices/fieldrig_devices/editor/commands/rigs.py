"""The command `fieldrig editor rigs`."""

from pathlib import Path
from typing import Annotated

from fieldrig.cli.common import argument, echo_json


def rigs(file: Annotated[Path, argument("FILE", "A program in ST, IL, PAM or ARP.")]) -> None:
    """List the rig files that name a program, in its folder and in those above it up to the current folder, as JSON."""
    from fieldrig_devices.editor.rigs import rigs_with

    echo_json([str(rig.absolute()) for rig in rigs_with(file, Path.cwd())])
