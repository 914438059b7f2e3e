"""A PAM application alone, with objects in memory, one basic cycle after the other."""

from collections.abc import Sequence

from fieldrig_devices.pam.runtime.compiler import compile_application
from fieldrig_devices.pam.runtime.item import Value
from fieldrig_devices.pam.runtime.memory_objects import MemoryItem, MemoryObjects
from fieldrig_devices.pam.runtime.processor import Limits
from fieldrig_devices.pam.runtime.readings import Readings
from fieldrig_devices.pam.runtime.runtime import Runtime

OBJECTS = """
APPLICATION NAME = bench V1.00; BASIC_PAM_CYCLE = 3; END
NODES_GROUP NGR_Both; NUMBER = 2; END
NODE NOD_Each; NODES_GROUP = NGR_Both; ADDRESS = 1; TYPE = ST1; END
NODE NOD_Io; ADDRESS = 17; TYPE = SMART_IO; END
AXIS AXI_Each; NODE = NOD_Each; PULSES_PER_UNIT = 1; TRAVEL_SPEED = 1; ACCELERATION = 1;
  INITIAL_POSITION = 0; POSITION_RANGE = 0 1; END
ENCODER ENC_One; NODE = NOD_Each; ADDRESS = 1; PULSES_PER_UNIT = 1; POSITION_PERIOD = 360; END
BINARY_INPUT SBI_a; NODE = NOD_Io; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
BINARY_INPUT SBI_b; NODE = NOD_Io; ADDRESS = 102; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
BINARY_INPUT SBI_c; NODE = NOD_Io; ADDRESS = 103; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
BINARY_OUTPUT SBO_a; NODE = NOD_Io; ADDRESS = 201; ACTIVE = HIGH; END
BINARY_OUTPUT SBO_Each; NODE = NOD_Each; ADDRESS = 201; ACTIVE = HIGH; END
DIGITAL_OUTPUT SDO_a; NODE = NOD_Io; BITS = 6; ADDRESS = 207; ACTIVE = HIGH; END
PAM_ANALOG_OUTPUT PAO_a; UNITS_PER_VOLT = 1000; OFFSET = 0; ADDRESS = 0; END
INTERNAL FLAG_VAR f; INTERNAL FLAG_VAR g; INTERNAL FLAG_VAR h;
INTERNAL WORD_VAR w; INTERNAL REAL_VAR r;
COMMON FLAG_VAR cf; COMMON WORD_VAR n; COMMON WORD_VAR at; COMMON REAL_VAR x; COMMON REAL_VAR y;
INTERNAL FLAG_VAR fe; NODES_GROUP = NGR_Both; END
INTERNAL WORD_VAR we; NUMBER = 3; END
"""
"""An application without programs: inputs a to c, an output, and variables of each class."""


class PamBench:
    """Values of single variables and inputs by their names, and lists of them for objects with several items."""

    def __init__(
        self,
        programs: str,
        *,
        header: str = OBJECTS,
        limits: Limits | None = None,
        readings: Readings | None = None,
        missing: int = -1,
    ) -> None:
        self.program = compile_application(header + programs, "bench.pam")
        self.messages: list[tuple[str, tuple[int, ...], str]] = []
        self._limits, self._readings = limits, readings
        self.runtime = Runtime(self.program, self._on_message, limits, readings)
        self.objects = MemoryObjects(self.program, self.runtime)
        if missing >= 0:
            self.objects.missing["NGR_Both"] = {missing}
        self.runtime.start(self.objects)

    def restart(self) -> None:
        """Run the application from its beginning, with the items that the objects have now."""
        self.runtime = self.objects.kernel = Runtime(self.program, self._on_message, self._limits, self._readings)
        self.runtime.start(self.objects)

    def _on_message(self, code: str, details: Sequence[int], text: str) -> None:
        self.messages.append((code, tuple(details), text))

    @property
    def errors(self) -> list[str]:
        """The messages apart from those of the start."""
        return [code for code, _, _ in self.messages if not code.startswith("07..M")]

    def run(self, cycles: int = 1) -> None:
        for _ in range(cycles):
            self.runtime.cycle()

    def item(self, name: str, number: int = 0) -> MemoryItem:
        return self.objects.items[name][number]

    def __getitem__(self, name: str) -> object:
        cells = self.program.layout.cells.get(name)
        if cells is None:
            return self.item(name).value()
        found = self.runtime.cells[cells.first : cells.first + cells.count]
        return found if cells.is_multiple else found[0]

    def __setitem__(self, name: str, value: Value | Sequence[Value]) -> None:
        cells = self.program.layout.cells.get(name)
        if cells is None:
            assert not isinstance(value, Sequence)
            self.item(name).hold(value)
            return
        for number, each in enumerate(value if isinstance(value, Sequence) else [value]):
            self.runtime.poke(cells.first + number, each)

    def trace(self, name: str, cycles: int) -> dict[int, object]:
        """Return the values of a variable by the numbers of the basic cycles in which it changed."""
        found, last = {}, self[name]
        for _ in range(cycles):
            self.run()
            if self[name] != last:
                last = found[self.runtime.cycle_number] = self[name]
        return found


def sequence(statements: str, *, cycles: int = 1, power_on: str = "", more: str = "", specs: str = "") -> str:
    """A task whose sequence SEQ_a is started by the input a."""
    return (
        f"TASK TSK_a; SPECS {specs} CYCLES = {cycles}; END_SPECS\n"
        "EVENTS ON_EVENT SBI_a XEQ_SEQUENCE SEQ_a; END_EVENTS\n"
        f"SEQUENCE SEQ_a;\n{statements}\nEND_SEQUENCE\n{more}"
        + (f"POWERON\n{power_on}\nEND_POWERON\n" if power_on else "")
        + "END_TASK\n"
    )


def started(
    statements: str, *, cycles: int = 1, power_on: str = "", more: str = "", readings: Readings | None = None
) -> PamBench:
    """A bench whose sequence has been started by the input a, in basic cycle 2 or the next one of its task."""
    bench = PamBench(sequence(statements, cycles=cycles, power_on=power_on, more=more), readings=readings)
    bench.run()
    bench["SBI_a"] = True
    bench.run(cycles)
    return bench


def computed(assignment: str, **values: Value) -> PamBench:
    """A bench that has carried out an assignment, with variables set before."""
    bench = PamBench(sequence(assignment))
    for name, value in values.items():
        bench[name] = value
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    return bench
