"""The FIFOs of the VME DualPort: order, capacity, and any interleaving of two sides (section 11.4; T27)."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pam_ports import started_vme

from fieldrig_devices.pam.ports.masters.script import Pause, Read, Script, Write
from fieldrig_devices.pam.ports.memory import WORDS, Memory
from fieldrig_devices.pam.ports.vme.fifo import Fifo
from fieldrig_devices.pam.ports.vme.layout import BLOCKS, HEAD, IN_HEADER, OUT_HEADER, TAIL

BLOCK = (1, 2, 3, 4, 5, 6, 7)


@pytest.mark.manual("PAMS-080")
def test_143_blocks_fit() -> None:
    memory = Memory()
    writer, reader = Fifo(memory, OUT_HEADER), Fifo(memory, OUT_HEADER)
    writer.reset()
    assert [writer.put((number, *BLOCK[1:])) for number in range(144)] == [True] * 143 + [False]
    assert memory.read(OUT_HEADER + HEAD, 1) == [143]
    assert reader.get() == (0, *BLOCK[1:])
    assert memory.read(OUT_HEADER + TAIL, 1) == [1]
    assert writer.put((143, *BLOCK[1:]))  # at the last place
    assert memory.read(OUT_HEADER + HEAD, 1) == [0]
    assert [block[0] for block in iter(reader.get, None)] == list(range(1, 144))
    assert reader.is_empty


@pytest.mark.parametrize("wrong", [144, 145, 0xFFFF])
def test_an_index_that_does_not_exist_leads_nowhere(wrong: int) -> None:
    memory = Memory()
    fifo = Fifo(memory, IN_HEADER)
    fifo.reset()
    memory.write(IN_HEADER + HEAD, [wrong])
    assert (fifo.get(), fifo.is_empty) == (None, True)
    memory.write(IN_HEADER + TAIL, [wrong])
    assert not fifo.put(BLOCK)


@pytest.mark.manual("PAMS-080", "PAMS-107", "PAML-248")
def test_a_full_output_fifo_is_reported_once() -> None:
    bench, master = started_vme()
    item = bench.item("DWO_MachCurrentPressure")
    for value in range(1, 150):
        item.set_value(value)
    assert bench.kernel.codes.count("07..E008") == 1
    assert [value for _, _, value in bench.play(master.take())] == list(range(1, BLOCKS))
    item.set_value(0)
    assert [value for _, _, value in bench.play(master.take())] == [0]


@pytest.mark.manual("PAMS-080")
def test_the_input_fifo_takes_143_blocks_between_two_cycles() -> None:
    bench, master = started_vme()
    assert [bench.play(master.put("DWI_MachPressure", value)) for value in range(144)] == [True] * 143 + [False]
    bench.cycles()
    assert bench.play(master.put("DWI_MachPressure", 0))


class Interleaved(list[int]):
    """Words that let the other side step before each access."""

    def __init__(self, step: Callable[[], None]) -> None:
        super().__init__([0] * WORDS)
        self.step = step

    def __getitem__(self, place: Any) -> Any:
        self.step()
        return super().__getitem__(place)

    def __setitem__(self, place: Any, value: Any) -> None:
        self.step()
        super().__setitem__(place, value)


def words_one_by_one(script: Script[Any], words: list[int]) -> Iterator[Any]:
    """Carry a script out with one word per step."""
    found: list[int] | None = None
    while True:
        try:
            access = script.send(found)  # type: ignore[arg-type]
        except StopIteration:
            return
        found = None
        match access:
            case Read(word=word, count=count):
                found = []
                for place in range(word, word + count):
                    found.append(list.__getitem__(words, place))
                    yield
            case Write(word=word, values=values):
                for place, value in enumerate(values, word):
                    list.__setitem__(words, place, value)
                    yield
            case Pause():
                yield


@pytest.mark.long
@pytest.mark.manual("PAMS-080")
@settings(max_examples=60, deadline=None)
@given(
    steps=st.lists(st.integers(0, 9), min_size=1, max_size=60),
    inputs=st.integers(0, 200),
    outputs=st.lists(st.integers(0, 3), max_size=60),
)
def test_no_interleaving_loses_or_doubles_a_block(steps: list[int], inputs: int, outputs: list[int]) -> None:
    bench, master = started_vme()
    received: list[int] = []
    sent: list[int] = []

    def other_side() -> Script[None]:
        value = 0
        while True:
            if value < inputs and (yield from master.put("DLI_MachHeadSpeed", value + 1, 0)):
                value += 1
            received.extend(int(found) for _, _, found in (yield from master.take()))
            yield Pause()

    shared = Interleaved(lambda: None)
    shared[:] = bench.memory.read(0, WORDS)
    taken: list[int] = []
    fifo_in, fifo_out = bench.ports._ports[0]._in, bench.ports._ports[0]._out  # type: ignore[attr-defined]
    fifo_in._words = fifo_out._words = shared
    stepping = words_one_by_one(other_side(), shared)
    turns = 0

    def step() -> None:
        nonlocal turns
        for _ in range(steps[turns % len(steps)]):
            next(stepping)
        turns += 1

    shared.step = step
    number = 0
    for burst in outputs:
        for _ in range(burst):
            number += 1
            if fifo_out.put((3, 0, 0, number, 0, 0, 0)):
                sent.append(number)
        taken.extend(block[3] for block in iter(fifo_in.get, None))
    shared.step = lambda: None
    for _ in range(20_000):
        next(stepping)
        if len(taken) == inputs and received == sent:
            break
        taken.extend(block[3] for block in iter(fifo_in.get, None))
    assert taken == list(range(1, inputs + 1))
    assert received == sent
