"""`fieldrig replay`: plays one side of a log to a rig, and compares what the rig sends with the other side."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli import completion
from fieldrig.cli.common import AsJson, Overrides, argument, assignment, duration_ns, echo_json, writing
from fieldrig.cli.trace_reading import During, From, part_ns, report_oddities
from fieldrig.system.exits import Exit

if TYPE_CHECKING:
    from fieldrig.config.rig_file import RigConfig

SECTION = "Run a rig"
"""The group of the command in the help of `fieldrig`."""

RigFile = Annotated[
    Path, typer.Option("--rig", metavar="RIG", help="The rig file.", autocompletion=completion.rig_file)
]
Play = Annotated[
    list[str] | None,
    typer.Option(
        "--play",
        metavar="SIDE",
        help="What is played: master (what no device of the rig sends), node=5, id=185, unit=3, client=10.0.0.7,"
        " sender=NAME, or a device of the rig, whose place the log takes. May be given several times."
        "  [default: master]",
        show_default=False,
    ),
]
TimeTolerance = Annotated[
    str, typer.Option("--time-tolerance", metavar="DURATION", help="How much faster or slower an answer may be.")
]
ValueTolerance = Annotated[
    list[str] | None,
    typer.Option(
        "--value-tolerance",
        metavar="OBJECT=NUMBER",
        help="How much an object or register may differ: 6064h=3, level=0.01, io/6401h:01=5. May be given several"
        " times.",
        show_default=False,
    ),
]
LeaveOut = Annotated[
    list[str] | None,
    typer.Option(
        "--leave-out",
        metavar="PATTERN",
        help="Do not compare an object, a register, an identifier or a PDO: 6064h, level, 185, 'io/TPDO*'."
        " May be given several times.",
        show_default=False,
    ),
]
Timeout = Annotated[
    str, typer.Option("--timeout", metavar="DURATION", help="Longest wait for an answer that the log shows.")
]
Settle = Annotated[
    str | None,
    typer.Option(
        "--settle",
        metavar="DURATION",
        help="How long the rig runs before the log begins, at least; 0s plays at once.  [default: 1s if the log does"
        " not show how its nodes boot; nodes that boot for longer are awaited]",
        show_default=False,
    ),
]
BusNames = Annotated[
    list[str] | None,
    typer.Option(
        "--bus",
        metavar="LOG=RIG",
        help="A bus of the log and the bus of the rig that it is: vcan0=can1. May be given several times.",
        show_default=False,
    ),
]
Speed = Annotated[
    float | None,
    typer.Option(
        "--speed",
        metavar="FACTOR",
        min=0.001,
        max=1000.0,
        help="In real time, this many times faster than recorded.  [default: in virtual time, without waiting]",
        show_default=False,
    ),
]
Real = Annotated[
    bool,
    typer.Option("--real", help="In real time: to the rig that runs, or else to one that is started for it."),
]
Junit = Annotated[
    Path | None, typer.Option("--junit", metavar="FILE", help="Write a JUnit report.", show_default=False)
]


def replay(
    file: Annotated[Path, argument("FILE", "The log.")],
    rig: RigFile,
    play: Play = None,
    overrides: Overrides = None,
    time_tolerance: TimeTolerance = "20ms",
    value_tolerance: ValueTolerance = None,
    leave_out: LeaveOut = None,
    timeout: Timeout = "1s",
    settle: Settle = None,
    bus: BusNames = None,
    begin: From = None,
    duration: During = None,
    real: Real = False,
    speed: Speed = None,
    junit: Junit = None,
    as_json: AsJson = False,
) -> None:
    """Play one side of a log to a rig, and compare the answers of the rig with those of the log.

    \b
    A request waits for its answer where the log shows one, and what follows is shifted. So a recording of the real
    machine is a test of its emulation, and of a changed program.
        fieldrig replay machine.blf --rig machine.yaml
        fieldrig replay monday.pcapng --rig lab.yaml --value-tolerance level=0.01 --junit replay.xml
        fieldrig replay lab.log --rig lab.yaml --play io        the log takes the place of the device `io`
        fieldrig replay lab.log --rig lab.yaml --real --speed 2
    The exit code is 0 if there is no difference, 1 if there is one, and 2 for a wrong file or option.
    """
    from fieldrig.traces.oddities import Oddities
    from fieldrig.traces.trace_files import read
    from fieldrig_devices.replay.calls import replay as replay_log
    from fieldrig_devices.replay.replay_report import show, to_junit
    from fieldrig_devices.replay.tolerances import value_tolerances

    odd = Oddities()
    result = replay_log(
        read(file, *part_ns(begin, duration), odd),
        _config(rig, overrides or (), is_real=real or speed is not None),
        play=play or (),
        time_tolerance_ns=duration_ns(time_tolerance),
        value_tolerances=value_tolerances(value_tolerance or ()),
        leave_out=leave_out or (),
        timeout_ns=duration_ns(timeout),
        settle_ns=None if settle is None else duration_ns(settle),
        buses=dict(assignment(word, "vcan0=can1") for word in bus or ()),
        speed=(speed or 1.0) if real or speed is not None else None,
    )
    report_oddities(file, odd)
    if junit is not None:
        with writing(junit):
            junit.write_bytes(to_junit(result, file.name, rig.name))
    if as_json:
        echo_json(result.as_data())
    else:
        show(result)
    raise typer.Exit(Exit.OK if result.is_same else Exit.DIFFERENT)


def _config(rig: Path, overrides: Sequence[str], *, is_real: bool) -> "RigConfig":
    from fieldrig.config.rig_file import load

    return load(rig, (*overrides, *(() if is_real else ("time=virtual",))))
