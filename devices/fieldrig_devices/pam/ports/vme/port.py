"""The PAM's end of the VME DualPort, called once per basic cycle (chapter 13).

Where the manual is silent, `PortOptions` chooses.  An output FIFO that is full is reported once until there is room.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from fieldrig_devices.pam.language.ports import ALL_ITEMS, PortPlan, PortVariable
from fieldrig_devices.pam.ports.dual_port import MASTER_CONFIGURATION, MASTER_READY, DualPort, DualPortState
from fieldrig_devices.pam.ports.memory import Memory
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.ports.panel import VME_PANEL
from fieldrig_devices.pam.ports.variables import IsActive, OutputChanges, PortItem, addressed
from fieldrig_devices.pam.ports.vme.crcs import with_crcs
from fieldrig_devices.pam.ports.vme.fifo import Fifo
from fieldrig_devices.pam.ports.vme.layout import (
    BLOCKS,
    IN_HEADER,
    OUT_HEADER,
    WATCHDOG,
    index_on_wire,
    item_on_wire,
    output_block,
    value_of,
)
from fieldrig_devices.pam.ports.vme.startup import NO_KEY, StartUp
from fieldrig_devices.pam.runtime.item import Kernel, Value

WATCHDOG_NS: Final = 10_000_000
"""Period of the watchdog (PAMS-081)."""

MOST_QUEUED: Final = BLOCKS
"""Changes of inputs that wait for one PERIOD; the manual gives no number (E02B)."""
_MESSAGES: Final[Mapping[DualPortState, str]] = {
    DualPortState.SYNC: "07..M01C",
    DualPortState.CONFIG_IN: "07..M007",
    DualPortState.INIT: "07..M012",
    DualPortState.WAIT_START: "07..M011",
}
_CONFIGURING: Final = frozenset(
    {DualPortState.CONFIG_IN, DualPortState.CONFIG_OUT, DualPortState.INIT, DualPortState.WAIT_START}
)
"""The states in which MASTER_CONFIGURATION_TIMEOUT counts."""
_SENDING: Final = frozenset({DualPortState.RUN, DualPortState.RUN_NO_MASTER})
_TIMEOUTS: Final = {DualPortState.SYNC: MASTER_READY, **dict.fromkeys(_CONFIGURING, MASTER_CONFIGURATION)}


class VmePort(DualPort):
    panel: int | None = VME_PANEL

    def __init__(
        self, plan: PortPlan, memory: Memory, kernel: Kernel, is_active: IsActive, options: PortOptions
    ) -> None:
        plan = replace(plan, variables=with_crcs(plan.variables, options))
        super().__init__(plan, kernel, is_active, options)
        self._memory = memory
        self.inputs = list(plan.inputs)
        self._outputs = {variable.crc: variable for variable in plan.outputs}
        self._is_sending = False
        self._in, self._out = Fifo(memory, IN_HEADER), Fifo(memory, OUT_HEADER)
        self._start_up = StartUp(memory, self, options)
        self._keys: dict[str, int] = {}
        self._queues: dict[int, list[tuple[PortVariable, int, Value]]] = {
            variable.period: [] for variable in self.inputs
        }
        self._watchdog_ns = 0
        self._changes = OutputChanges(self._write, kernel)

    # ---- for the PAM

    def begin(self, now_ns: int) -> None:
        """Start up, after power-on or a hardware reset."""
        self._now_ns = now_ns
        self.status.set_error(False)
        self._keys.clear()
        self._changes.clear()
        for queue in self._queues.values():
            queue.clear()
        for items in self.items.values():
            for item in items:
                item.preset()
        self._in.reset()
        self._out.reset()
        self._start_up.begin()
        if self._options.without_master:
            self._kernel.report("07..M01F")
            self.enter(DualPortState.RUN_ALONE)
        else:
            self.enter(DualPortState.SYNC)

    def poll(self, now_ns: int) -> None:
        """Take the steps of this basic cycle: start-up, commands and watchdog."""
        self._now_ns = now_ns
        if self.may_run:
            self._start_up.poll()
            if now_ns >= self._watchdog_ns and self.state in _SENDING:
                # After the last instant and not after this cycle, so that the period does not drift with the cycles.
                self._watchdog_ns = max(self._watchdog_ns + WATCHDOG_NS, now_ns)
                self._look_for_master()
        elif self.state is DualPortState.SYNC:
            if self._start_up.synchronise() and self.state is DualPortState.SYNC:
                self._wait(MASTER_READY)
        elif self.state in _CONFIGURING:
            if self.state is DualPortState.INIT and self._start_up.is_reading:
                self._initialise()
            if self._start_up.poll() and self.state in _CONFIGURING:
                self._wait(MASTER_CONFIGURATION)
        self._fail_if_late()

    def take(self) -> None:
        """Read the input FIFO, and update the inputs that are due."""
        if self.state is not DualPortState.RUN:
            return
        for _ in range(BLOCKS):
            number = self._in.index
            block = self._in.get()
            if block is None:
                break
            self._queue(block, number)
        cycle = self._kernel.cycle_number
        for period, queue in self._queues.items():
            if queue and cycle % period == 0:
                self._update(queue)

    # ---- start-up

    @property
    def is_in_empty(self) -> bool:
        return self._in.is_empty

    def enter(self, state: DualPortState, timeout: str = "") -> None:
        super().enter(state, timeout or _TIMEOUTS.get(state, ""))
        self._is_sending = state in _SENDING
        if state in _MESSAGES:
            self._kernel.report(_MESSAGES[state])
        if state is DualPortState.RUN:
            self._watchdog_ns = self._now_ns + WATCHDOG_NS
            self._watchdog.begin(self._now_ns)

    def configure(self, crc: int, key: int) -> PortVariable | None:
        variable = self._outputs.get(crc)
        if variable is None:
            self._kernel.report("07..E028", (crc, key, 0))
            return None
        self._keys[variable.name] = key  # its value is 0 since the start-up has begun
        return variable

    def _initialise(self) -> None:
        for _ in range(BLOCKS):
            block = self._in.get()
            if block is None:
                return
            addressed_input = self._addressed(block)
            if addressed_input is not None:
                variable, index = addressed_input
                for item in addressed(self.items[variable.name], index):
                    item.preset(value_of(variable.kind, block[3:]))

    # ---- inputs

    def _addressed(self, block: tuple[int, ...]) -> tuple[PortVariable, int] | None:
        """Return the input and the item of a block; a wrong key or index is reported (PAMS-075)."""
        key = block[0]
        if not 1 <= key <= len(self.inputs):
            self._kernel.report("07..E029", (key, NO_KEY, 0))
            return None
        variable = self.inputs[key - 1]
        index = item_on_wire(variable, block[2], self._options.first_item)
        if index >= variable.number and not (index == ALL_ITEMS and variable.is_multiple):
            self._kernel.report("07..E02A", (key, variable.compiler_id, block[2]))
            return None
        return variable, index

    def _queue(self, block: tuple[int, ...], number: int) -> None:
        addressed_input = self._addressed(block)
        if addressed_input is None:
            return
        variable, index = addressed_input
        queue = self._queues[variable.period]
        if len(queue) >= MOST_QUEUED:
            self._kernel.report("07..E02B", (variable.period, MOST_QUEUED, number))
            return
        queue.append((variable, index, value_of(variable.kind, block[3:])))

    def _update(self, queue: list[tuple[PortVariable, int, Value]]) -> None:
        """Take the last value of each item over, so that a period raises one event (PAMS-079)."""
        latest = {
            item: value for variable, index, value in queue for item in addressed(self.items[variable.name], index)
        }
        queue.clear()
        for item, value in latest.items():
            item.receive(value)

    # ---- outputs

    def _push(self, item: PortItem) -> None:
        """Write a change of an output that the master knows."""
        key = self._keys.get(item.variable.name, NO_KEY)
        if self._is_sending and key != NO_KEY and item.is_served:
            self._changes.add(item)

    def _write(self, item: PortItem) -> bool:
        """Write the value of an output; return False if there is no room."""
        variable = item.variable
        index = index_on_wire(variable, item.index, self._options.first_item)
        return self._out.put(output_block(self._keys[variable.name], index, variable.kind, item.value()))

    # ---- watchdog

    def _take_watchdog(self) -> bool:
        words = self._memory.words
        is_served = words[WATCHDOG] == 1
        if is_served:
            words[WATCHDOG] = 0
        return is_served
