"""The methods force, release and forced, with the variables of a real program."""

import pytest

from fieldrig.clock import VirtualClock
from fieldrig_bus.opcua.message import AnyValue, Status
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.runtime import MOST_FORCED, Runtime
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.opcua.forcing import forcing
from fieldrig_devices.opcua.methods import MethodsTree
from fieldrig_devices.opcua.symbols import SymbolsTree
from fieldrig_devices.opcua.tree import WrongArgumentsError

PROGRAM = """
FUNCTION_BLOCK Belt VAR_IN_OUT total : INT; END_VAR VAR position : DINT; END_VAR END_FUNCTION_BLOCK
VAR_GLOBAL CONSTANT highest : INT := 3; END_VAR
VAR_GLOBAL grid : ARRAY[0..1, 5..6] OF INT; many : ARRAY[1..1001] OF BOOL; END_VAR
PROGRAM PLC_PRG
VAR belt : Belt; small : INT(0..10); values : ARRAY[1..3] OF INT; count : INT; countdown : INT; END_VAR
count := count + 1; values[2] := 9;
END_PROGRAM
"""


class Bench:
    def __init__(self) -> None:
        host = StandaloneHost(VirtualClock())
        compiled = compile_project([SourceFile("plc.st", PROGRAM)], host)
        self.runtime = Runtime(compiled, host)
        self.thread = self.runtime.thread(compiled.program.pous["plc_prg"])
        variables = SymbolsTree(compiled.symbols, self.runtime)
        self.tree = MethodsTree(forcing(lambda: variables))

    def cycle(self) -> None:
        self.thread.start()
        self.thread.run(10**9)

    def read(self, path: str) -> object:
        return self.runtime.read(self.runtime.find(path))

    def call(self, name: str, *arguments: AnyValue) -> object:
        results = self.tree.call(f"{name}()", arguments)
        return results[0] if results else None

    @property
    def forced(self) -> object:
        return self.call("forced")


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_forced_variable_keeps_its_value_until_it_is_released(bench: Bench) -> None:
    bench.call("force", "plc_prg.COUNT", 40)
    bench.cycle()
    assert (bench.read("PLC_PRG.count"), bench.forced) == (40, ["PLC_PRG.count"])
    bench.call("force", "PLC_PRG.count", 50)
    bench.cycle()
    assert (bench.read("PLC_PRG.count"), bench.forced) == (50, ["PLC_PRG.count"])
    bench.call("release", "PLC_PRG.count")
    bench.cycle()
    assert (bench.read("PLC_PRG.count"), bench.forced) == (51, [])


def test_an_array_is_forced_and_released_element_by_element(bench: Bench) -> None:
    bench.call("force", "PLC_PRG.values", [1, 2, 3])
    bench.cycle()
    assert [bench.read(f"PLC_PRG.values[{index}]") for index in (1, 2, 3)] == [1, 2, 3]
    bench.call("release", "PLC_PRG.values[2]")
    assert bench.forced == ["PLC_PRG.values[1]", "PLC_PRG.values[3]"]
    bench.call("release", "PLC_PRG.values")
    assert bench.forced == []


@pytest.mark.parametrize(
    ("released", "left"),
    [
        ("", []),
        ("PLC_PRG", ["grid[0,5]", "grid[1,6]"]),
        ("grid[0]", ["grid[1,6]", "PLC_PRG.count", "PLC_PRG.countdown", "PLC_PRG.belt.position"]),
        ("grid", ["PLC_PRG.count", "PLC_PRG.countdown", "PLC_PRG.belt.position"]),
        ("PLC_PRG.count", ["grid[0,5]", "grid[1,6]", "PLC_PRG.countdown", "PLC_PRG.belt.position"]),
        ("nothing", ["grid[0,5]", "grid[1,6]", "PLC_PRG.count", "PLC_PRG.countdown", "PLC_PRG.belt.position"]),
    ],
)
def test_release_means_a_node_with_everything_below_it(bench: Bench, released: str, left: list[str]) -> None:
    for path in ("grid[0,5]", "grid[1,6]", "PLC_PRG.count", "PLC_PRG.countdown", "PLC_PRG.belt.position"):
        bench.call("force", path, 1)
    bench.call("release", released)
    assert bench.forced == left


@pytest.mark.parametrize(
    ("path", "value", "statuses"),
    [
        ("PacDriveM.Timer1", 1, (Status.NOT_SUPPORTED, Status.GOOD)),
        ("PLC_PRG", 1, (Status.NOT_WRITABLE, Status.GOOD)),
        ("highest", 1, (Status.NOT_WRITABLE, Status.GOOD)),
        ("PLC_PRG.small", 11, (Status.GOOD, Status.OUT_OF_RANGE)),
        ("PLC_PRG.values", 1, (Status.GOOD, Status.TYPE_MISMATCH)),
        ("PLC_PRG.values", [1, 2], (Status.GOOD, Status.OUT_OF_RANGE)),
        ("PLC_PRG.values", [1, 2, 40_000], (Status.GOOD, Status.OUT_OF_RANGE)),
    ],
)
def test_arguments_that_are_wrong_have_their_status(
    bench: Bench, path: str, value: AnyValue, statuses: tuple[Status, Status]
) -> None:
    with pytest.raises(WrongArgumentsError) as refused:
        bench.call("force", path, value)
    assert (refused.value.statuses, bench.forced) == (statuses, [])


def test_what_cannot_be_forced_now_is_refused_with_its_reason(bench: Bench) -> None:
    with pytest.raises(ValueError, match="refers to nothing yet"):
        bench.call("force", "PLC_PRG.belt.total", 1)
    with pytest.raises(ValueError, match=str(MOST_FORCED)):
        bench.call("force", "many", [True] * (MOST_FORCED + 1))
    assert bench.forced == []


def test_without_a_program_nothing_is_forced() -> None:
    tree = MethodsTree(forcing(lambda: None))
    assert tree.call("forced()", ()) == [[]]
    assert tree.call("release()", ("",)) == ()
    with pytest.raises(WrongArgumentsError):
        tree.call("force()", ("PLC_PRG.count", 1))
