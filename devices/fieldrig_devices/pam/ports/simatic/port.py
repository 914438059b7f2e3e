"""The PAM's end of the Simatic S5 DualPort, called once per basic cycle (chapter 14).

A word that is announced in the input FIFO gets the value that its cell has at the end of the PERIOD.  A change that
finds the output FIFO full is in its cell.  `PortOptions` chooses whether it is announced when there is room.
"""

from collections.abc import Iterator, Sequence
from typing import Final

from fieldrig_devices.pam.language.ports import PortPlan
from fieldrig_devices.pam.ports.dual_port import MASTER_CONFIGURATION, MASTER_READY, DualPort, DualPortState
from fieldrig_devices.pam.ports.memory import Memory
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.ports.panel import BEFORE_WATCH_DOG
from fieldrig_devices.pam.ports.simatic.cells import (
    EVEN_BYTE,
    INDEX_SHIFTS,
    AddressFifo,
    Place,
    bit_place,
    flag_of,
    item_place,
    set_flag,
)
from fieldrig_devices.pam.ports.simatic.scan import Scan
from fieldrig_devices.pam.ports.variables import IsActive, OutputChanges, PortItem
from fieldrig_devices.pam.runtime.item import Kernel

WATCHDOG_CYCLES: Final = 10
"""Basic cycles between two looks at WATCH_DOG (PAMS-093)."""
MOST_ENTRIES: Final = 128
"""Entries of the input FIFO that are read in one basic cycle."""
_ROUNDS: Final = 2


class SimaticPort(DualPort):
    def __init__(
        self, plan: PortPlan, memory: Memory, kernel: Kernel, is_active: IsActive, options: PortOptions
    ) -> None:
        super().__init__(plan, kernel, is_active, options)
        self._words = memory.words
        watch_dog, self._period = plan.numbers("WATCH_DOG")[0], plan.numbers("PERIOD")[0]
        self._watch_dog, self.panel = watch_dog // 2, watch_dog - BEFORE_WATCH_DOG
        self._pam_ready, self._dualport_ready, self._host_ready = (
            bit_place(*plan.numbers(name)) for name in ("PAM_READY", "DUALPORT_READY", "HOST_READY")
        )
        shift = INDEX_SHIFTS[options.fifo_index_byte]
        self._in, self._out = (AddressFifo(memory, plan, name, shift) for name in ("FIFO_IN", "FIFO_OUT"))
        inputs = [item for variable in plan.inputs for item in self.items[variable.name]]
        self._outputs = [item for variable in plan.outputs for item in self.items[variable.name]]
        self._places = {item: item_place(item.variable, item.index) for item in (*inputs, *self._outputs)}
        self._scan = Scan(memory, self._flags(inputs), self._period)
        self._input_words = {self._places[item].address: item for item in inputs if item.variable.kind == "WORD_VAR"}
        self._announced: dict[PortItem, None] = {}
        """Input words that are updated at the end of the period, in the order of the FIFO."""
        self._changes = OutputChanges(self._announce, kernel)
        self._round = self._cycles = 0

    def _flags(self, items: Sequence[PortItem]) -> Iterator[tuple[Place, PortItem]]:
        return ((self._places[item], item) for item in items if item.variable.kind == "FLAG_VAR")

    # ---- for the PAM

    def begin(self, now_ns: int) -> None:
        """Start up, after power-on or a hardware reset (manual lines 10393 to 10402)."""
        self._now_ns = now_ns
        self.status.set_error(False)
        self._announced.clear()
        self._changes.clear()
        self._round = self._cycles = 0
        set_flag(self._words, self._host_ready, False)
        set_flag(self._words, self._dualport_ready, False)
        self._in.reset()
        self._out.reset()
        for item in self._places:
            item.preset()
        for item in self._outputs:
            self._write(item)
        if self._options.without_master:
            self._kernel.report("07..M01E")
            self.enter(DualPortState.RUN_ALONE)
            return
        if self._options.pam_ready == "set_first":
            set_flag(self._words, self._pam_ready, True)
        self._kernel.report("07..M01B")
        self.enter(DualPortState.SYNC, MASTER_READY)

    def poll(self, now_ns: int) -> None:
        """Take the steps of this basic cycle: start-up and watchdog."""
        self._now_ns = now_ns
        if self.may_run:
            self._cycles += 1
            is_due = self._cycles % WATCHDOG_CYCLES == 0 and self.state is not DualPortState.RUN_ALONE
            if is_due:
                self._look_for_master()
        elif self.state is DualPortState.SYNC and not flag_of(self._words, self._pam_ready):
            self._synchronise()
        elif self.state is DualPortState.WAIT_HOST and flag_of(self._words, self._host_ready):
            self._run()
        else:
            self._fail_if_late()

    def take(self) -> None:
        """Scan input flags, read the input FIFO, and update the input words that are due."""
        if self.state is not DualPortState.RUN:
            return
        cycle_number = self._kernel.cycle_number
        for item, value in self._scan.changes(cycle_number):
            if item.is_served:
                item.receive(value)
        self._read_fifo()
        if self._announced and cycle_number % self._period == 0:
            for item in self._announced:
                item.receive(self._words[self._places[item].cell])
            self._announced.clear()

    # ---- start-up

    def _synchronise(self) -> None:
        set_flag(self._words, self._pam_ready, True)
        self._round += 1
        if self._round < _ROUNDS:
            self.enter(DualPortState.SYNC, MASTER_READY)
            return
        self._kernel.report("07..M01D")
        self.enter(DualPortState.WAIT_HOST, MASTER_CONFIGURATION)

    def _run(self) -> None:
        """Read the initial inputs, which the host has written without the FIFO, and begin."""
        for item, value in self._scan.all():
            if item.is_served:
                item.preset(value)
        for item in self._input_words.values():
            if item.is_served:
                item.preset(self._words[self._places[item].cell])
        set_flag(self._words, self._dualport_ready, True)
        self._kernel.report("07..M006")
        self._kernel.report("07..M011")
        self._watchdog.begin(self._now_ns)
        self.enter(DualPortState.RUN)

    # ---- variables

    def _read_fifo(self) -> None:
        for _ in range(MOST_ENTRIES):
            address = self._in.get()
            if address is None:
                return
            item = self._input_words.get(address)
            if item is None:
                self._kernel.report("07..E011", (address,))
            elif item.is_served:
                self._announced[item] = None

    def _push(self, item: PortItem) -> None:
        """Write a change of an output to its cell, and announce the cell."""
        if not self.may_run or self.state is DualPortState.RUN_ALONE or not item.is_served:
            return
        self._write(item)
        self._changes.add(item)

    def _announce(self, item: PortItem) -> bool:
        return self._out.put(self._places[item].address)

    def _write(self, item: PortItem) -> None:
        place = self._places[item]
        if item.variable.kind == "WORD_VAR":
            self._words[place.cell] = int(item.value()) & 0xFFFF
        else:
            set_flag(self._words, place, bool(item.value()))

    # ---- watchdog

    def _take_watchdog(self) -> bool:
        word = self._words[self._watch_dog]
        is_served = word & EVEN_BYTE == EVEN_BYTE
        if is_served:
            self._words[self._watch_dog] = word & ~EVEN_BYTE
        return is_served
