"""Test files with TEST blocks, written and run in a folder."""

import json
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from fieldrig_devices.iec.commands import app
from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.testing.blocks import BlockSource
from fieldrig_devices.iec.testing.case import Limits, Outcome

MOTOR = """\
FUNCTION_BLOCK Motor
VAR_INPUT start, stop : BOOL; END_VAR
VAR_OUTPUT run : BOOL; calls : INT; END_VAR
VAR longest : TON; END_VAR
IF start THEN run := TRUE; END_IF;
longest(IN := run, PT := T#1s);
IF stop OR longest.Q THEN run := FALSE; END_IF;
calls := calls + Step(1);
END_FUNCTION_BLOCK

FUNCTION Step : INT
VAR_INPUT size : INT; END_VAR
Step := size;
END_FUNCTION
"""
LAMP_RIG = """\
time: virtual
buses:
  wires: {kind: wires.virtual}
devices:
  terminal:
    kind: hmiscu
    model: HMISCU6A5
    links: {wires: wires}
    terminals: {DI0: switch.on, DQ0: lamp.on}
    program: lamp.st
"""
"""A controller with an input `switch.on` and an output `lamp.on`, whose program is lamp.st."""
STUCK_LAMP = """\
VAR_GLOBAL presses : INT; END_VAR
PROGRAM PLC_PRG
VAR
  switch AT %IX0.0 : BOOL;
  lamp AT %QX0.0 : BOOL;
  edge : R_TRIG;
END_VAR
edge(CLK := switch);
IF edge.Q THEN presses := presses + 1; END_IF
lamp := switch OR presses >= 3;
END_PROGRAM
"""
"""A program for it, with a mistake: the third press leaves the lamp on."""


def written(folder: Path, **files: str) -> Path:
    """Write `name="text"` as `name.st`, and return the folder."""
    for name, text in files.items():
        (folder / f"{name}.st").write_text(text)
    return folder


def outcomes(file: Path, dialect: str = "edition-3", timeout_s: float = 10.0) -> dict[str, Outcome]:
    """Run all tests of a file, and return their outcomes by name."""
    source = BlockSource(file, DIALECTS[dialect])
    return {one.case.name: one for one in source.run(source.cases(), Limits(timeout_s))}


def one(folder: Path, body: str, others: str = "", dialect: str = "edition-3", timeout_s: float = 10.0) -> Outcome:
    """Run one test with this text between TEST and END_TEST, beside the motor; `others` are declared with it."""
    written(folder, motor=MOTOR, motor_test=f"{others}\nTEST 'it'\n{body}\nEND_TEST\n")
    return outcomes(folder / "motor_test.st", dialect, timeout_s)["it"]


def iec_test(*arguments: object, dialect: str = "edition-3") -> Any:
    """Call `fieldrig iec test`."""
    return CliRunner().invoke(app, ["test", *map(str, arguments), "--dialect", dialect])


def as_json(*arguments: object) -> Any:
    done = iec_test(*arguments, "--json")
    return json.loads(done.stdout)
