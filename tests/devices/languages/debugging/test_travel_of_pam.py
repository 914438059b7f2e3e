"""The way back of a PAM, whose program goes on a cycle after it is asked to, and which begins without one."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from debug_session import DebugSession
from shipped import in_virtual_time
from travelling import travelling

from fieldrig import MS, S
from fieldrig_devices.languages.debugging.travel import Travel

pytestmark = [
    pytest.mark.system,
    pytest.mark.long,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork"),
]
LINES = Path("configs/programs/labeller.pam").read_text(encoding="utf-8").splitlines()
SET, RESET = (next(n for n, line in enumerate(LINES, 1) if f"AliveBelt <- {what}" in line) for what in ("set", "reset"))
BEGIN = next(n for n, line in enumerate(LINES, 1) if "IFV_Begin <- set" in line)


@pytest.fixture
def session() -> Iterator[DebugSession]:
    with travelling(in_virtual_time("pam-machine.yaml"), "pam") as rig:
        made = DebugSession(rig.ask, lambda ms: rig.run_for(ms * MS), travel=Travel("pam", rig.ask, rig.ask_rig))
        rig.run_until(2 * S)
        yield made


def here(session: DebugSession) -> tuple[int, str]:
    """Return the line that is next, and the value of the output."""
    line = int(session.do("where")[0].partition(".pam:")[2].partition(":")[0])
    return line, session.do("print SBO_AliveBelt")[0].partition(" = ")[2]


def test_a_way_back_stops_where_an_earlier_one_had_stopped(session: DebugSession) -> None:
    session.do(f"break {RESET}", "continue", "continue", "reverse-continue", "delete", "watch SBO_AliveBelt")
    session.do("continue", "continue", "back")
    assert here(session) == (SET, "FALSE")
    session.do("reverse-continue")
    assert here(session) == (RESET, "TRUE")
    session.do("reverse-continue")
    assert here(session) == (SET, "FALSE")


def test_the_first_change_after_the_program_was_loaded_is_found(session: DebugSession) -> None:
    [told] = session.do("last IFV_Begin")
    assert told.startswith("IFV_Begin FALSE -> TRUE")
    assert told.endswith(f"labeller.pam:{BEGIN}")


def test_a_variable_that_has_never_changed_is_said_so(session: DebugSession) -> None:
    with pytest.raises(ValueError, match="IFV_Dead has not changed"):
        session.do("last IFV_Dead")
