"""`fieldrig diff`: compares two logs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli.common import AsJson, argument, duration_ns, echo_json
from fieldrig.cli.message_words import OfRig
from fieldrig.cli.trace_reading import During, From, part_ns, report_oddities
from fieldrig.system.exits import Exit
from fieldrig_devices.named_logs.options import Eds, Registers, named_log

if TYPE_CHECKING:
    from fieldrig_devices.replay.diff_result import DiffResult

SECTION = "Files"
"""The group of the command in the help of `fieldrig`."""

Tolerance = Annotated[
    str, typer.Option("--tolerance", metavar="DURATION", help="Differences of time up to this one are jitter.")
]
Window = Annotated[
    str,
    typer.Option("--window", metavar="DURATION", help="Messages further apart than this are different messages."),
]
Offset = Annotated[
    str | None,
    typer.Option(
        "--offset",
        metavar="DURATION",
        help="How much later B is, such as 1.5s or -20ms.  [default: found from the messages of both]",
        show_default=False,
    ),
]
LeaveOut = Annotated[
    list[str] | None,
    typer.Option(
        "--leave-out",
        metavar="PATTERN",
        help="Leave out an identifier, unit, wire or sender: 705, can0/705, 'unit 3*'. May be given several times.",
        show_default=False,
    ),
]


def diff(
    left: Annotated[Path, argument("A", "The log to compare with.")],
    right: Annotated[Path, argument("B", "The log that may differ from it.")],
    rig: OfRig = None,
    eds: Eds = None,
    registers: Registers = None,
    tolerance: Tolerance = "5ms",
    window: Window = "1s",
    offset: Offset = None,
    leave_out: LeaveOut = None,
    begin: From = None,
    duration: During = None,
    as_json: AsJson = False,
) -> None:
    """Compare two logs: the first difference with what was around it, and a table of all.

    \b
    The logs may have different formats and may have begun at different times. Each identifier, unit, wire and sender is
    compared for itself, so one missing message is one difference, however long the logs are.
        fieldrig diff monday.log tuesday.pcapng
        fieldrig diff monday.log tuesday.log --rig lab.yaml       values by name
        fieldrig diff monday.blf tuesday.blf --eds 5=io32.eds --registers 1=meter.yaml
        fieldrig diff a.jsonl b.jsonl --tolerance 20ms --leave-out 705
    The exit code is 0 if there is no difference, 1 if there is one, and 2 for a wrong file or option, or for two logs
    that have no message to compare.
    """
    from fieldrig.traces.oddities import Oddities
    from fieldrig.traces.trace_files import read
    from fieldrig_devices.replay.comparison import compare_logs
    from fieldrig_devices.replay.diff_report import as_data, show
    from fieldrig_devices.replay.leave_out import LeftOut
    from fieldrig_devices.replay.log_names import LogNames

    odd, named = (Oddities(), Oddities()), named_log(rig, eds, registers)
    part = part_ns(begin, duration)
    untold = {left: odd[0], right: odd[1]}
    result = compare_logs(
        lambda: read(left, *part, untold.pop(left, None)),  # a log is read again for what is around
        lambda: read(right, *part, untold.pop(right, None)),
        tolerance_ns=duration_ns(tolerance),
        horizon_ns=duration_ns(window),
        offset=None if offset is None else _signed_ns(offset),
        leave_out=LeftOut(leave_out or ()),
        names=(LogNames(named), LogNames(named)),
    )
    for path, oddities in zip((left, right), odd, strict=True):
        report_oddities(path, oddities)
    if as_json:
        echo_json(as_data(result))
    else:
        show(result, left.name, right.name, LogNames(named))
    raise typer.Exit(_code(result))


def _signed_ns(text: str) -> int:
    return -duration_ns(text[1:]) if text.startswith("-") else duration_ns(text)


def _code(result: "DiffResult") -> int:
    return Exit.OK if result.is_same else Exit.DIFFERENT
