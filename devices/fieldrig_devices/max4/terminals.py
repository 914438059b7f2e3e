"""Digital inputs and outputs, and measuring inputs (touch probes).

Source: PacDrive manual 3608-3655, 6967-6969 (digest PD-021, PD-022, PD-194); inputs are read and outputs written at the
moment of access (PD-070).  A measuring input latches the positions of all axes at its rising edge, interpolated
linearly between two cycles.  Its parameters are our choice.
"""

from collections.abc import Callable, Mapping
from functools import partial

from fieldrig.clock import Clock
from fieldrig.device import Value
from fieldrig.link import Link
from fieldrig_bus.wires import Signal
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.configuration.tree import Access, Object, Parameter, Type


class DigitalInput:
    """A digital input, with its parameter."""

    def __init__(self, node: Object) -> None:
        self.object = node
        self.value = False
        self.watcher: Callable[[bool], None] | None = None
        """Called after each change: the input area of the program."""
        node.group("General").add(Parameter("Value", Type.BOOL, read=lambda: self.value))

    def put(self, is_on: bool) -> None:
        self.value = is_on
        if self.watcher is not None:
            self.watcher(is_on)


class DigitalOutput:
    """A digital output, with its parameter."""

    def __init__(self, node: Object, on_change: Callable[[bool], None]) -> None:
        self.object = node
        self.value = False
        self.watcher: Callable[[bool], None] | None = None
        """Called after each change: the output area of the program."""
        self._on_change = on_change
        node.group("General").add(
            Parameter(
                "Value", Type.BOOL, Access.INPUT, read=lambda: self.value, write=lambda value: self.put(bool(value))
            )
        )

    def put(self, is_on: bool) -> None:
        if is_on is not self.value:
            self.value = is_on
            self.show()

            if self.watcher is not None:
                self.watcher(is_on)

    def show(self) -> None:
        self._on_change(self.value)


class MeasuringInput:
    """A measuring input, which counts edges and latches the positions of all axes at each edge."""

    def __init__(self, clock: Clock, node: Object, axes: Mapping[str, Axis], cycle_ns: int) -> None:
        self._clock, self._axes, self._cycle_ns = clock, axes, cycle_ns
        self.object = node
        self.value = False
        self.count = 0
        self.positions: dict[str, int] = dict.fromkeys(axes, 0)
        self._edge_ns: int | None = None
        self._before: dict[str, int] = {}
        general = node.group("General")
        general.add(Parameter("Value", Type.BOOL, read=lambda: self.value))
        general.add(Parameter("Count", Type.UDINT, read=lambda: self.count))
        for name in axes:
            general.add(
                Parameter(f"Position_{name}", Type.LREAL, unit="incr", read=partial(self.positions.__getitem__, name))
            )

    def put(self, is_on: bool) -> None:
        if is_on and not self.value and self._edge_ns is None:
            self._edge_ns = self._clock.now_ns()
            self._before = {name: axis.position for name, axis in self._axes.items()}
        self.value = is_on

    def step(self, last_ns: int) -> None:
        """Latch positions, once per cycle with new actual values; the ones before arrived at `last_ns`."""
        if self._edge_ns is None:
            return
        span_ns = max(self._clock.now_ns() - last_ns, 1)
        share = min(max((self._edge_ns - last_ns) / span_ns, 0.0), 1.0)
        for name, axis in self._axes.items():
            before = self._before[name]
            self.positions[name] = round(before + (axis.position - before) * share)
        self._edge_ns = None
        self.count += 1


class Terminals:
    """All terminals of a controller, connected to their wires."""

    def __init__(self, wires: Link[Signal] | None) -> None:
        self._wires = wires
        self._listeners: dict[str, list[Callable[[Signal], None]]] = {}
        self.inputs: dict[str, DigitalInput] = {}
        self.outputs: dict[str, DigitalOutput] = {}
        self.measuring: dict[str, MeasuringInput] = {}

    def listen(self, wire: str, handler: Callable[[Signal], None]) -> None:
        if wire:
            self._listeners.setdefault(wire, []).append(handler)

    def start(self) -> None:
        if self._wires is not None and self._listeners:
            self._wires.on_receive(self._on_signal, sorted(self._listeners))
        for output in self.outputs.values():
            output.show()

    def fall(self) -> None:
        """Switch all outputs off, because the power is off."""
        for output in self.outputs.values():
            output.put(False)

    def drive(self, wire: str, value: Value) -> None:
        if wire and self._wires is not None:
            self._wires.send(Signal(wire, bool(value)))

    def _on_signal(self, signal: Signal) -> None:
        for handler in self._listeners.get(signal.name, ()):
            handler(signal)
