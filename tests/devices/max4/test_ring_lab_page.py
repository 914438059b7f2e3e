"""The CiA 402 program of docs/ring-lab.md, a hundred times: it holds, and the client library has nothing to warn of."""

import logging
import re
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import canopen
import pytest
from can_face_bench import CanFaceBench
from canopen.pdo.base import PdoMap
from canopen.profiles import p402

PAGE = Path(__file__).parents[3] / "docs" / "ring-lab.md"
NODE_ID = 1
WANTED = 3_000_000
"""Increments from where the axis was homed."""


def program() -> str:
    found = re.search(r"```python file can_move\.py\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    return found[1]


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> CanFaceBench:
    """A controller whose time passes while the program looks at the clock or sleeps."""
    bench = CanFaceBench(simulated=("infeed",), can_axes={"node_ids": [NODE_ID]}).run(3_000)

    def monotonic() -> float:
        return bench.run(1).rig.now_ns / 1e9

    def disconnect() -> None:
        bench.wire.subscribers.clear()
        bench.wire.nodes.clear()

    monkeypatch.setattr(p402, "time", SimpleNamespace(monotonic=monotonic))
    monkeypatch.setattr(time, "sleep", lambda seconds: bench.run(seconds * 1_000))
    monkeypatch.setattr(PdoMap, "wait_for_reception", lambda pdo, timeout=10: bench.wait_for(pdo, timeout))
    monkeypatch.setattr(canopen, "Network", lambda: bench.wire)
    monkeypatch.setattr(bench.wire, "connect", lambda **bus: None)
    monkeypatch.setattr(bench.wire, "disconnect", disconnect)
    return bench


def play(bench: CanFaceBench, capsys: pytest.CaptureFixture[str], code: Any) -> None:
    exec(code, {"__name__": "__main__"})  # the page's own program
    said = capsys.readouterr().out
    assert said.startswith("infeed is at ")
    assert int(said.rpartition(" ")[2]) == pytest.approx(WANTED, abs=2_000)


@pytest.mark.parametrize("count", [3, pytest.param(100, marks=[pytest.mark.long, pytest.mark.timeout(1800)])])
def test_program_of_the_page_homes_and_moves_each_time_without_a_warning(
    bench: CanFaceBench, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture, count: int
) -> None:
    caplog.set_level(logging.INFO)
    code = compile(program(), str(PAGE), "exec")
    for _ in range(count):
        play(bench, capsys, code)
    assert [one.getMessage() for one in caplog.records if one.levelno >= logging.WARNING] == []
    assert sum("Homing mode carried out" in one.getMessage() for one in caplog.records) == count
