"""A program takes all that its compilation made with it, and its memory needs no search for circular garbage."""

import gc
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from weakref import ref

import pytest
from hmiscu_device_bench import PTO, DeviceBench
from iec_program import IecBench
from iec_program import program as program_of
from plc_bench import PlcBench

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.solo import Solo
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages import garbage
from fieldrig_devices.languages.garbage import GarbageCollection
from fieldrig_devices.languages.source_file import SourceFile

TEXT = program_of("x : DINT; t : TON;", "x := x + 1; t(IN := TRUE, PT := T#1s);")


@pytest.fixture(autouse=True)
def python_never_searches() -> Iterator[None]:
    usual = gc.get_threshold()
    gc.set_threshold(1_000_000_000)
    yield
    gc.set_threshold(*usual)


def test_memory_goes_with_a_program_that_has_run() -> None:
    bench = IecBench(TEXT)
    bench.runtime.break_at({"main.st": {3}})
    bench.cycle()
    memory = ref(bench.runtime._memory)
    del bench
    assert memory() is None


def test_memory_goes_with_a_program_and_its_tasks() -> None:
    clock = VirtualClock()
    host = StandaloneHost(clock)
    solo = Solo(clock, host, compile_project([SourceFile("a.st", TEXT)], host))
    solo.start()
    solo.run_until(50_000_000)
    memory = ref(solo.program.runtime._memory)
    solo.program.scheduler.end()
    del solo._program  # as a controller does at a download
    assert memory() is None


@pytest.mark.long
def test_memory_of_an_hmiscu_goes_with_a_download(tmp_path: Path) -> None:
    bench = DeviceBench(tmp_path, TEXT, channel_0=PTO)
    bench.run(95)
    program = bench.device._plc.program
    assert program is not None
    memory = ref(program.runtime._memory)
    del program
    bench.device.answer("debug", {"command": "part", "file": "program.st", "text": TEXT})
    bench.device.answer("debug", {"command": "download", "online": False})
    bench.run(1_000)
    assert memory() is None


@pytest.mark.long
def test_memory_of_a_max_4_goes_with_a_download(tmp_path: Path) -> None:
    bench = PlcBench(tmp_path, TEXT).boot()
    bench.run(100)
    memory = ref(bench.loaded.runtime._memory)
    bench.max4.answer("debug", {"command": "part", "file": "plc.st", "text": TEXT})
    bench.max4.answer("debug", {"command": "download", "online": False})
    bench.run(1_000)
    assert memory() is None


def test_code_goes_with_an_online_change() -> None:
    bench = IecBench(TEXT)
    bench.cycle()
    code = bench.runtime.code
    bench.runtime.change(bench.compile(TEXT.replace("+ 1", "+ 2"), bench.compiled))
    assert code._functions == {}
    bench.cycle()
    assert bench["x"] == 3


def test_what_compilations_left_is_searched_for_when_there_is_much_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    class Circle:
        def __init__(self) -> None:
            self.own = self

    monkeypatch.setattr(garbage, "MOST_LEFT", 2_000)
    collection, circles = GarbageCollection(), list[ref[Circle]]()
    for number in range(4):
        with collection.paused():
            assert not gc.isenabled()
            circles += [ref(Circle()) for _ in range(300)]  # 600 objects
        assert gc.isenabled()
        assert all(circle() is None for circle in circles) == (number == 3)


A_THOUSAND = f"""
from fieldrig.clock import VirtualClock
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages.source_file import SourceFile

for number in range(1_000):
    host = StandaloneHost(VirtualClock())
    Runtime(compile_project([SourceFile("a.st", {TEXT!r})], host), host).thread
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="other systems count the memory of a process differently")
def test_a_thousand_programs_in_one_process_take_less_than_300_mb() -> None:
    # Not by getrusage, whose peak begins with that of the process that starts this one.
    counted = f"{A_THOUSAND}\nprint(open('/proc/self/status').read())"
    found = subprocess.run([sys.executable, "-c", counted], capture_output=True, text=True, check=True)
    peak = re.search(r"VmHWM:\s*(\d+) kB", found.stdout)
    assert peak is not None
    assert int(peak[1]) < 300 * 1024
