"""The CiA 402 programs of the pages, a hundred times: they hold, and the client library has nothing to warn of."""

import logging
import re
import time
from types import CodeType, SimpleNamespace
from typing import NamedTuple

import canopen
import pytest
from can_face_bench import CanFaceBench, dictionary_of
from canopen.node import base
from canopen.pdo.base import PdoMap
from canopen.profiles import p402
from doc_pages import page_named


class Program(NamedTuple):
    page: str
    file: str
    axis: str
    node_id: int
    wanted: int
    """Increments that the output reports: a distance, or the position after homing."""
    homings: int

    def __str__(self) -> str:
        return self.page

    @property
    def code(self) -> CodeType:
        found = re.search(rf"```python file {self.file}\n(.*?)```", page_named(self.page).read_text("utf-8"), re.DOTALL)
        assert found is not None
        return compile(found[1], self.file, "exec")


PROGRAMS = (
    Program("ring-lab.md", "can_move.py", "infeed", 1, 3_000_000, homings=1),
    Program("cia402.md", "can_belt.py", "belt", 10, 1_000_000, homings=0),
)


@pytest.fixture(params=PROGRAMS, ids=str)
def program(request: pytest.FixtureRequest) -> Program:
    found: Program = request.param
    return found


@pytest.fixture
def bench(program: Program, monkeypatch: pytest.MonkeyPatch) -> CanFaceBench:
    """A controller whose time passes while the program looks at the clock or sleeps."""
    bench = CanFaceBench(simulated=(program.axis,), can_axes={"node_ids": [program.node_id]}).run(3_000)

    def monotonic() -> float:
        return bench.run(1).rig.now_ns / 1e9

    def disconnect() -> None:
        bench.wire.subscribers.clear()
        bench.wire.nodes.clear()

    monkeypatch.setattr(p402, "time", SimpleNamespace(monotonic=monotonic))
    monkeypatch.setattr(time, "sleep", lambda seconds: bench.run(seconds * 1_000))
    monkeypatch.setattr(PdoMap, "wait_for_reception", lambda pdo, timeout=10: bench.wait_for(pdo, timeout))
    monkeypatch.setattr(base, "import_od", dictionary_of)  # a hundred programs read one file
    monkeypatch.setattr(canopen, "Network", lambda: bench.wire)
    monkeypatch.setattr(bench.wire, "connect", lambda **bus: None)
    monkeypatch.setattr(bench.wire, "disconnect", disconnect)
    return bench


def play(program: Program, capsys: pytest.CaptureFixture[str], code: CodeType) -> None:
    exec(code, {"__name__": "__main__"})  # the page's own program
    said = capsys.readouterr().out
    assert said.startswith(f"{program.axis} ")
    assert int(said.rpartition(" ")[2]) == pytest.approx(program.wanted, abs=2_000)


@pytest.mark.usefixtures("bench")
@pytest.mark.parametrize("count", [3, pytest.param(100, marks=[pytest.mark.long, pytest.mark.timeout(1800)])])
@pytest.mark.long
def test_program_of_a_page_moves_its_axis_each_time_without_a_warning(
    program: Program, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture, count: int
) -> None:
    caplog.set_level(logging.INFO)
    code = program.code
    for _ in range(count):
        play(program, capsys, code)
    assert [record.getMessage() for record in caplog.records if record.levelno >= logging.WARNING] == []
    homings = sum("Homing mode carried out" in record.getMessage() for record in caplog.records)
    assert homings == count * program.homings
