"""The state of a card in words."""

from collections.abc import Iterator
from typing import Any, Final

from fieldrig.points.values import counted
from fieldrig_devices.arp.user_port.messages import Condition, Identity, ProgramCode
from fieldrig_devices.arp.user_port.quantities import state_name

STATES: Final = {
    "INIT": "starting",
    "RESET_ENABLE": "reset: Enable (I108) is open",
    "RESET_COMMAND": "reset by Ctrl-F2; `fieldrig arp run` ends the reset",
    "RUN": "runs",
    "STOPPED": "stopped; `fieldrig arp run` starts it again",
    "BLOCKED": "blocked by an error: open and close Enable, or `fieldrig arp reset`",
}
PROGRAMS: Final = {
    ProgramCode.NONE: "none; `fieldrig arp download FILE` downloads one",
    ProgramCode.HELD: "held at its first instruction",
    ProgramCode.RUNNING: "running",
    ProgramCode.PAUSED: "paused",
    ProgramCode.ENDED: "ended",
    ProgramCode.FAILED: "failed",
}
CODES: Final = {
    103: "memory cannot be read or written",
    105: "reset: Enable is open",
    106: "CAN: bus-off, or a node is lost",
    111: "the program stopped: there is none, or it cannot be run",
    112: "calls are nested more than 10 deep",
    113: "invalid parameters of an instruction",
    116: "an axis has lost control",
    201: "division by zero",
    202: "a result is outside -999999.999 to 999999.999",
    203: "a parameter of an instruction is out of range",
    204: "memory was not initialised",
}
"""Texts of error and warning codes (digest 10.3)."""


def program_name(code: int) -> str:
    return ProgramCode(code).name.lower() if code in PROGRAMS else str(code)


def as_data(identity: Identity, condition: Condition) -> dict[str, Any]:
    return {
        "number": identity.number,
        "name": identity.name,
        **condition._asdict(),
        "state": state_name(condition.state),
        "program": program_name(condition.program),
    }


def lines(identity: Identity, condition: Condition) -> Iterator[str]:
    name = state_name(condition.state)
    yield f"card {identity.number:02}: {name} ({STATES.get(name, 'unknown')})"
    program = PROGRAMS.get(ProgramCode(condition.program)) if condition.program in PROGRAMS else "unknown"
    if name == "STOPPED" and condition.program == ProgramCode.PAUSED:
        program = "stopped"  # the program keeps its place, but cannot be continued
    place = f", line {condition.line}" if condition.line else ""
    stops = f", {counted(condition.breakpoints, 'breakpoint')}" if condition.breakpoints else ""
    yield f"program {identity.name}: {program}{place}{stops}" if identity.name else f"program: {program}"
    axis = f", axis {condition.error_axis}" if condition.error_axis else ""
    yield f"error: {_code(condition.error)}{axis}"
    yield f"warning: {_code(condition.warning)}"


def _code(code: int) -> str:
    return f"{code} ({CODES.get(code, 'reserved')})" if code else "none"
