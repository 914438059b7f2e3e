"""The rigs of configs/ring.yaml and packaging-line.yaml in virtual time: hands on the controller, eyes on drives."""

from collections.abc import Callable, Iterator, Mapping
from itertools import count
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from device_of import device_of

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS
from fieldrig.config.rig_file import load
from fieldrig.device import Value
from fieldrig.storage.store import MemoryStore
from fieldrig.virtual.rig import Rig
from fieldrig_bus.wires import Signal
from fieldrig_devices.max4.axes.axis import Axis, Mode
from fieldrig_devices.max4.controller import Max4

CONFIGS = Path(__file__).parents[2] / "configs"
RING, LINE = CONFIGS / "ring.yaml", CONFIGS / "packaging-line.yaml"
DRIVES = ("infeed", "film", "jaw", "outfeed")
RPM_TO_INCREMENTS = 1_000_000 / 60
SEEN = ("axis_state", "mc4_state", "brake", "torque_on", "ready", "diag_code")
"""The points in the timing diagrams of the manual's chapter 10."""
PATIENCE_MS = 30_000


class Follower:
    """Set values of one axis: from where it is, by a function of the milliseconds since then."""

    def __init__(self, path: Callable[[float], float], cycle_ms: float, mode: Mode = Mode.POSITION) -> None:
        self._path, self._cycle_ms, self.mode = path, cycle_ms, mode
        self._begun_at = 0
        self._cycles: Iterator[int] = iter(())

    def begin(self, axis: Axis) -> None:
        self._begun_at, self._cycles = axis.position, count(1)

    def next(self) -> float:
        value = self._path(next(self._cycles) * self._cycle_ms)
        return self._begun_at + round(value) if self.mode is Mode.POSITION else value

    def end(self) -> None:
        pass


class RingLab:
    def __init__(self, *overrides: str, file: Path = RING, stores: Mapping[str, MemoryStore] | None = None) -> None:
        """`overrides` are those of `--set`.  Messages are German, as the manual prints them."""
        self.signals: list[tuple[int, str, Any]] = []
        self.trace: list[str] | None = None
        self.rig = Rig(load(file, ("time=virtual", "devices.max4.language=de", *overrides)), self._on_delivery, stores)
        self.names = tuple(name for name, device in self.rig.config.devices.items() if device.kind == "mc4")

    def _on_delivery(self, bus: Bus[Any], delivery: Delivery[Any]) -> None:
        message = delivery.message
        if self.trace is not None:
            data, receivers = bus.encode(message).hex(), ",".join(delivery.receivers)
            self.trace.append(f"{delivery.time_ns} {bus.name} {delivery.sender} {data} {receivers}")
        if type(message) is Signal:
            self.signals.append((delivery.time_ns // MS, message.name, message.value))

    def values_of(self, wire: str) -> list[Any]:
        """The values that a wire has had."""
        return [value for _, name, value in self.signals if name == wire]

    # ---- time

    def run(self, ms: float) -> Self:
        self.rig.run_until(self.rig.now_ns + round(ms * MS))
        return self

    def until(self, condition: Callable[[], bool]) -> Self:
        end_ns = self.rig.now_ns + PATIENCE_MS * MS
        while not condition():
            assert self.rig.now_ns < end_ns, "it did not come"
            self.run(4)
        return self

    def boot(self) -> Self:
        """Run until the boot has finished, and a second longer for the drives' parameters."""
        return self.until(lambda: self.get("booted") is True).run(2_000)

    # ---- the controller

    @property
    def max4(self) -> Max4:
        return device_of(self.rig, "max4", Max4)

    def get(self, key: str) -> Value:
        return self.rig.get("max4", key)

    def set(self, key: str, value: Value) -> Self:
        self.rig.set("max4", key, value)
        return self

    def do(self, words: str) -> Self:
        return self.set("command", words)

    def enable(self, *names: str) -> Self:
        for name in names or self.names:
            self.set(f"{name}.ControllerEnable", True)
        return self.run(300)

    def disable(self, *names: str) -> Self:
        for name in names or self.names:
            self.set(f"{name}.ControllerEnable", False)
        return self

    def follow(self, name: str, path: Callable[[float], float], mode: Mode = Mode.POSITION) -> Self:
        """Increments, from where it is, by milliseconds."""
        self.max4.firmware.axes[name].follow(Follower(path, self.max4.firmware.cycle_ns / MS, mode))
        return self

    def turn(self, name: str, rpm: float, ramp_ms: float = 1_000) -> Self:
        """Bring an axis up to a speed, and keep it."""
        per_ms = rpm * RPM_TO_INCREMENTS / 1_000

        def path(ms: float) -> float:
            ramp = min(ms, ramp_ms)
            return per_ms * (ramp * ramp / 2 / ramp_ms + max(ms - ramp_ms, 0))

        self.follow(name, path).run(ramp_ms + 200)
        assert abs(self.speed(name) - rpm) < 0.02 * abs(rpm)
        return self

    def log(self) -> list[str]:
        """Oldest first, without the numbers, with a blank where the tool has a tab."""
        return [" ".join(line.split("\t")[1:]).rstrip() for line in str(self.get("log")).splitlines()[::-1]]

    def codes(self) -> list[int]:
        return [int(line.split("\t")[5]) for line in str(self.get("log")).splitlines()[::-1]]

    def diagnosis(self) -> tuple[Value, Value, Value]:
        return self.get("DiagCode"), self.get("DiagExtCode"), self.get("DiagMsg")

    # ---- drives

    def of(self, drive: str, key: str) -> Value:
        return self.rig.get(drive, key)

    def speed(self, drive: str) -> float:
        return float(self.of(drive, "speed"))

    def states(self, drive: str) -> tuple[Value, Value]:
        """Return the states of the controller's axis object."""
        return self.get(f"{drive}.AxisState"), self.get(f"{drive}.MC4State")

    def course(self, drive: str, ms: int) -> list[tuple[Value, ...]]:
        """How the drive's signals change: the milliseconds from now, and then `SEEN`."""
        course: list[tuple[Value, ...]] = []
        for at_ms in range(ms + 1):
            seen = tuple(self.of(drive, key) for key in SEEN)
            if not course or seen != course[-1][1:]:
                course.append((at_ms, *seen))
            self.run(1)
        return course

    def fault(self, where: str, what: str, **more: Any) -> int:
        return self.rig.add_fault(where, {"what": what, **more})

    def heal(self, where: str, number: int) -> Self:
        self.rig.clear_fault(where, number)
        return self

    def close(self) -> None:
        self.rig.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None, tb: TracebackType | None) -> None:
        self.close()
