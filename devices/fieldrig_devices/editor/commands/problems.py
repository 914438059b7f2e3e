"""The command `fieldrig editor problems`."""

import dataclasses
from pathlib import Path
from typing import Annotated

from fieldrig.cli.common import argument, echo_json
from fieldrig_devices.iec.commands.sources import DialectOption


def problems(
    file: Annotated[Path, argument("FILE", "A rig file, or a program in ST, IL, PAM or ARP.")],
    dialect: DialectOption = "epas-4",
) -> None:
    """List what is wrong with a file and those that belong to it, in one form for all kinds of files, as JSON.

    \b
        fieldrig editor problems configs/lab.yaml
        fieldrig editor problems configs/programs/conveyor.st

    A program that a rig file in its folder, or in one above it up to the current folder, names is checked with its
    controller; one without is checked with the files beside it whose declarations it reaches. Each problem has `file`,
    `line` and `column` from 1, `severity` (error, warning or note) and `message`. The exit code is 0.
    """
    from fieldrig_devices.editor.problems import problems_of

    echo_json([dataclasses.asdict(problem) for problem in problems_of(file, Path.cwd(), dialect)])
