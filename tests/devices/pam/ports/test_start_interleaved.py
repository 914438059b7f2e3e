"""Both sides of a start-up in any order of their accesses: neither waits for the other without end."""

from collections.abc import Iterator
from typing import Any, Literal

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pam_ports import GROUP, SIMATIC, VME, PortBench

from fieldrig_devices.pam.ports.masters.s5 import S5Master
from fieldrig_devices.pam.ports.masters.script import Pause, Read, Script, Write
from fieldrig_devices.pam.ports.masters.vme import VmeMaster
from fieldrig_devices.pam.ports.options import PortOptions

SHORT_VME = GROUP + VME.replace("TIMEOUT = 500", "TIMEOUT = NONE")
SHORT_SIMATIC = GROUP + SIMATIC.replace("= 20000", "= NONE").replace("TIMEOUT = 500", "TIMEOUT = NONE")

turns = st.lists(st.integers(0, 3), min_size=1, max_size=40)
"""Basic cycles of the PAM before the accesses of the master, again and again."""
begins = st.integers(0, 60)
"""The access of the master before which the PAM gets its power."""


def meet(bench: PortBench, script: Script[None], turns: list[int], begin: int) -> None:
    """Carry a script out with cycles of the PAM between its accesses; AssertionError if it does not come to its end."""
    patience = Patience(bench, turns, begin)
    found: Any = None
    while True:
        patience.turn()
        try:
            access = script.send(found)
        except StopIteration:
            return
        found = None
        match access:
            case Read(word=word, count=count):
                found = [next(iter(patience.each(place, bench))) for place in range(word, word + count)]
            case Write(word=word, values=values):
                for place, value in enumerate(values, word):
                    patience.turn()
                    bench.memory.write(place, [value])
            case Pause():
                patience.turn()


class Patience:
    """Lets the PAM run for some cycles at a time, and ends a test in which nothing comes to an end."""

    def __init__(self, bench: PortBench, turns: list[int], begin: int) -> None:
        self._bench, self._turns, self._begin = bench, turns if any(turns) else [1], begin
        self._count = 0

    def turn(self) -> None:
        if self._count == self._begin:
            self._bench.begin()
        if self._count >= self._begin:
            self._bench.cycles(self._turns[self._count % len(self._turns)])
        self._count += 1
        assert self._count < 20_000, self._bench.ports.states

    def each(self, place: int, bench: PortBench) -> Iterator[int]:
        self.turn()
        yield bench.memory.read(place, 1)[0]


@pytest.mark.long
@pytest.mark.manual("PAMS-067")
@settings(max_examples=30)
@given(
    turns,
    begins,
    st.sampled_from([0, 1, 0xFFFF]),
    st.sampled_from(["pam", "master"]),
    st.sampled_from(["as_inputs", "first"]),
    st.sampled_from([0, 1]),
)
def test_vme(
    turns: list[int],
    begin: int,
    stale: int,
    cleared_by: Literal["pam", "master"],
    reply: Literal["as_inputs", "first"],
    first: Literal[0, 1],
) -> None:
    options = PortOptions(command_cleared_by=cleared_by, def_out_reply=reply, first_item=first)
    bench = PortBench(SHORT_VME, options)
    bench.memory.write(0, [stale] * 2048)
    master = VmeMaster(bench.variables, options)
    meet(bench, master.start_up({"DWI_MachPressure": 7}), turns, begin)
    assert bench.ports.states == {"DualPort": "running"}
    assert bench.value("DWI_MachPressure") == 7
    assert not master.mistakes


@pytest.mark.long
@pytest.mark.manual("PAMS-091")
@settings(max_examples=30)
@given(turns, begins, st.sampled_from([0, 0xFFFF]), st.sampled_from(["even", "odd"]))
@example([0, 0, 0, 0, 1], 2, 0xFFFF, "even")
def test_simatic(turns: list[int], begin: int, stale: int, byte: Literal["even", "odd"]) -> None:
    options = PortOptions(fifo_index_byte=byte)
    bench = PortBench(SHORT_SIMATIC, options)
    bench.memory.write(0, [stale] * 2048)
    meet(bench, S5Master(bench.plans[0], options).start_up({"DWI_MachPressure": 7}), turns, begin)
    # A host that has read the cell of PAM_READY before power-on, and writes it after, brings DUALPORT_READY back.  It
    # goes on too early then, so the PAM may be some steps behind.
    bench.cycles(3)
    assert bench.ports.states == {"DualPort": "running"}
    assert bench.value("DWI_MachPressure") == 7
