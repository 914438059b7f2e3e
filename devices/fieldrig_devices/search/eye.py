"""Sees in which states a machine is while it runs, without being an event for it.

A state is what one device shows at a time (`state_places`), the wires that controllers have switched on, a branch of a
program that has run, the steps of its charts that are active, or a code with which something was refused.
"""

from collections import deque
from collections.abc import Iterator, Sequence
from hashlib import sha256
from typing import TYPE_CHECKING, Any, Final

from fieldrig.clock import MS
from fieldrig.coverage import collecting
from fieldrig.coverage.places import Kind, Marked
from fieldrig.errors import ControlError
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusResponse
from fieldrig_bus.wires import Signal
from fieldrig_devices.scenarios.places import RigPlace, place_of
from fieldrig_devices.search.state_places import Sort, state_places

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig

LOOK_NS: Final = 20 * MS
"""The time between two looks at points; they choose what is searched next, and judge nothing."""
WINDOW_NS: Final = 5 * MS
WINDOWS: Final = 10
"""The branches that have run in this many windows, and in the present one, are the way to what happens now."""
ABORT: Final = 0x80
"""The command byte of an aborted transfer (CiA 301, 7.2.4.3.17), and the sign of an exception of Modbus."""

State = tuple[Any, ...]


class Eye:
    """Looks at a rig from now on; a branch of the rig has a copy of it."""

    def __init__(self, rig: "Rig", sorts: frozenset[Sort], further: Sequence[str]) -> None:
        """`further` are places that are one more state together."""
        self._rig, self._sorts = rig, sorts
        self._keys = state_places(rig, sorts)
        self._further = [place_of(rig, name) for name in further]
        self._programs: list[Marked] = []
        self._again: list[tuple[int, Marked]] = []
        """Programs that were loaded again, such as after a restart, each with the number that it had before."""
        self._loaded = 0
        self._steps: list[list[int]] = []
        """The marks of the steps of each program."""
        self._sum: list[int] = []
        """The marks that were passed, as the bytes of a number, which are joined fast."""
        self._windows: deque[list[int]] = deque(maxlen=WINDOWS)
        self._window_ns = self._look_ns = rig.now_ns
        self._is_on: dict[str, bool] = {}
        """The levels of the wires that are not those of plants."""
        self._states: set[State] = set()
        self._is_looking = False
        self._controllers = {name for name, one in rig.config.devices.items() if not one.kind.startswith("plant.")}
        rig.on_instant(self._on_instant)
        if sorts & {Sort.ABORTS, Sort.OUTPUTS}:
            rig.on_delivery(self._on_delivery)

    def forget(self) -> None:
        """Begin with the states from the present instant on; before that, none are noted."""
        self._is_looking = True
        self._states.clear()
        self._look()

    def states(self) -> frozenset[State]:
        """Return the states since then."""
        self._look()
        return frozenset(self._states)

    def marks(self) -> bytes:
        """Return a byte for each mark of all programs: 1 if it was passed since the begin."""
        self._turn()
        return b"".join(self._bytes(number, marks) for number, marks in enumerate(self._sum))

    def way(self) -> bytes:
        """Return the marks that were passed in the last 50 ms."""
        windows = [*self._windows, self._passed()]
        sums = [
            _joined(window[number] for window in windows if number < len(window)) for number in range(len(self._sum))
        ]
        return b"".join(self._bytes(number, marks) for number, marks in enumerate(sums))

    def _bytes(self, number: int, marks: int) -> bytes:
        return marks.to_bytes(len(self._programs[number].hits), "little")

    def _on_instant(self) -> None:
        now_ns = self._rig.now_ns
        if now_ns >= self._window_ns:
            self._window_ns = (now_ns // WINDOW_NS + 1) * WINDOW_NS
            self._turn()
        if self._is_looking and now_ns >= self._look_ns:
            self._look_ns = (now_ns // LOOK_NS + 1) * LOOK_NS
            self._look()

    def _turn(self) -> None:
        """Begin a new window."""
        window = self._passed()
        self._windows.append(window)
        for number, marks in enumerate(window):
            self._sum[number] |= marks
        for one in (*self._programs, *(again for _, again in self._again)):
            one.hits[:] = bytes(len(one.hits))

    def _passed(self) -> list[int]:
        """Return the marks of each program that were passed in this window."""
        if Sort.PROGRAMS in self._sorts and len(collecting.programs()) > self._loaded:
            self._note_loaded()
        passed = [_number(one.hits) for one in self._programs]
        for number, one in self._again:
            passed[number] |= _number(one.hits)
        return passed

    def _note_loaded(self) -> None:
        """Note the programs that were loaded since; one that was loaded before has the number that it had."""
        loaded = collecting.programs()
        for one in loaded[self._loaded :]:
            number = next((number for number, known in enumerate(self._programs) if known.places == one.places), None)
            if number is not None:
                self._again.append((number, one))
                continue
            self._programs.append(one)
            self._sum.append(0)
            self._steps.append([mark for mark, place in one.places if place.kind is Kind.STEP])
        self._loaded = len(loaded)

    def _look(self) -> None:
        self._states.update(self._present())

    def _present(self) -> Iterator[State]:
        rig = self._rig
        for device, keys in self._keys.items():
            try:
                yield (device, *map(_coarse, rig.values(device, keys).values()))
            except ControlError:  # it has no power now
                yield (device,)
        if self._further:
            yield ("places", *map(_shown, self._further))
        yield ("wires", frozenset(name for name, is_on in self._is_on.items() if is_on))
        for number, steps in enumerate(self._steps):
            if steps and self._windows and number < len(self._windows[-1]):
                window = self._windows[-1][number]
                yield ("steps", number, frozenset(mark for mark in steps if window >> (8 * mark) & 1))

    def _on_delivery(self, bus: Any, delivery: Any) -> None:
        message = delivery.message
        if isinstance(message, Signal):
            if isinstance(message.value, bool) and delivery.sender in self._controllers and Sort.OUTPUTS in self._sorts:
                self._is_on[f"{bus.name}/{message.name}"] = message.value
        elif Sort.ABORTS in self._sorts:
            self._states.update(_refused(bus.name, message))


def digest_of(state: State) -> bytes:
    """Return 8 bytes for a state, which are the same in each process."""
    return sha256(repr(_ordered(state)).encode()).digest()[:8]


def _ordered(value: object) -> object:
    """Return a value with its sets in an order of their own."""
    if isinstance(value, frozenset):
        return "set", *sorted(map(repr, map(_ordered, value)))
    return tuple(map(_ordered, value)) if isinstance(value, tuple) else value


def _shown(place: RigPlace) -> object:
    try:
        return _coarse(place.read())
    except ControlError:  # its device has no power now
        return None


def _refused(bus: str, message: object) -> Iterator[State]:
    match message:
        case CanFrame() if 0x580 <= message.identifier < 0x680 and len(message.data) == 8 and message.data[0] == ABORT:
            yield ("abort", bus, message.identifier, message.data[4:])
        case ModbusResponse() if message.pdu and message.pdu[0] & ABORT:
            yield ("abort", bus, message.unit, message.pdu[:2])


def _number(hits: Sequence[int]) -> int:
    return int.from_bytes(bytes(hits), "little")


def _joined(numbers: Iterator[int]) -> int:
    joined = 0
    for number in numbers:
        joined |= number
    return joined


def _coarse(value: object) -> object:
    """Return a value as a part of a state: of a real number only its order of magnitude says something new."""
    return float(f"{value:.0e}") if isinstance(value, float) else value
