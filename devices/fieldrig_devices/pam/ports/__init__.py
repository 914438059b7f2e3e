"""The ports of a PAM to its PLC: VME DualPort, Simatic S5 DualPort and RS422 (chapters 13 to 15).

`Ports` has everything that the PAM device needs.  It is passive; instants are handed in.

    memory = Memory()                       2048 words; `access` says how a master reaches them
    ports = Ports(program, memory, kernel)  the Kernel is called from `begin` on
    ports.items                             DualPort, RS422Port and all variables of ports, by name
    ports.begin(now_ns)                     power-on or hardware reset: start-up begins
    ports.poll(now_ns)                      first in each basic cycle, also while the application waits to run
    ports.may_run                           True when the application may begin; it goes on if the master is lost
    ports.take(), ports.give()              as every part of `Objects`, while the application runs
    ports.fail(origin, number, when)        fatal error: the panel is written, and the watchdog is silent
    ports.receive(data)                     bytes from the RS422 line; `send` of the constructor takes those for it
    ports.states                            the state of each port, as a text

A port that does not get ready in time reports 07..F020 to the Kernel and stops.  The PAM then calls `fail`, as for
every fatal error, and only `begin` leads on.
"""

from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from typing import Protocol

from fieldrig_devices.pam.language.items import Program
from fieldrig_devices.pam.language.ports import PortPlan, ports_of
from fieldrig_devices.pam.language.words import PREDECLARED
from fieldrig_devices.pam.ports.memory import ByteOrder, Memory
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.ports.panel import SERIAL_PANEL, panel_cells
from fieldrig_devices.pam.ports.rs422.port import Rs422Port
from fieldrig_devices.pam.ports.simatic.port import SimaticPort
from fieldrig_devices.pam.ports.variables import IsActive, PortItem, PortStatus
from fieldrig_devices.pam.ports.vme.port import VmePort
from fieldrig_devices.pam.runtime.item import Item, Kernel


class Port(Protocol):
    """One port."""

    status: PortStatus
    items: Mapping[str, Sequence[PortItem]]

    @property
    def panel(self) -> int | None:
        """Byte address of the fatal error panel, if this port decides it."""

    @property
    def may_run(self) -> bool: ...

    @property
    def state_text(self) -> str: ...

    def begin(self, now_ns: int) -> None: ...

    def poll(self, now_ns: int) -> None: ...

    def take(self) -> None: ...

    def give(self) -> None: ...

    def fail(self) -> None: ...


def _all_active(_group: str, _component: int) -> bool:
    return True


def byte_order_of(program: Program, options: PortOptions) -> ByteOrder:
    """Return the order of bytes for clients of the memory that see bytes."""
    is_simatic = any(plan.kind == "DUAL_PORT" for plan in ports_of(program))
    return options.byte_order or ("little" if is_simatic else "big")


class Ports:
    """All ports of one application."""

    def __init__(
        self,
        program: Program,
        memory: Memory,
        kernel: Kernel,
        options: PortOptions | None = None,
        is_active: IsActive = _all_active,
        send: Callable[[bytes], None] = lambda _: None,
    ) -> None:
        """`is_active` returns whether a component of a NODES_GROUP is active, by its name and number from 0."""
        self.memory, self._kernel = memory, kernel
        self._options = options or PortOptions()
        plans = {plan.declaration.name: plan for plan in ports_of(program)}
        self._ports: list[Port] = []
        if "DualPort" in plans:
            self._ports.append(self._dual_port(plans["DualPort"], is_active))
        self._serial = None
        if "RS422Port" in plans:
            self._serial = Rs422Port(plans["RS422Port"], kernel, is_active, send, self._options.rs422_baud)
            self._ports.append(self._serial)
        self.items: Mapping[str, Sequence[Item]] = {
            "DUALPORT": [PortStatus("DualPort", None, kernel)],
            "RS422PORT": [PortStatus("RS422Port", None, kernel)],
            **{PREDECLARED[port.status.name]: [port.status] for port in self._ports},
            **{name: items for port in self._ports for name, items in port.items.items()},
        }

    def _dual_port(self, plan: PortPlan, is_active: IsActive) -> Port:
        port_class = VmePort if plan.kind == "VME DUALPORT" else SimaticPort
        return port_class(plan, self.memory, self._kernel, is_active, self._options)

    @property
    def may_run(self) -> bool:
        return all(port.may_run for port in self._ports)

    @property
    def states(self) -> Mapping[str, str]:
        return {port.status.name: port.state_text for port in self._ports}

    def begin(self, now_ns: int) -> None:
        if "DualPort" not in self.states:
            self._kernel.report("07..M005")
        for port in self._ports:
            port.begin(now_ns)

    def poll(self, now_ns: int) -> None:
        for port in self._ports:
            port.poll(now_ns)

    def take(self) -> None:
        for port in self._ports:
            port.take()

    def give(self) -> None:
        for port in self._ports:
            port.give()

    def receive(self, data: bytes) -> None:
        if self._serial is not None:
            self._serial.receive(data)

    def fail(self, origin: int, number: int, when: datetime, tag: int = 0, info: int = 0) -> None:
        """Write the fatal error panel; `tag` 1 says that `info` is a node, and 2 that it is a peripheral."""
        for port in self._ports:
            port.fail()
        panel = next((port.panel for port in self._ports if port.panel is not None), SERIAL_PANEL)
        self.memory.write(panel // 2, panel_cells(origin, number, when, tag, info))
