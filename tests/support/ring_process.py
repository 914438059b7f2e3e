"""The ring of configs/ring.yaml as a user has it: `fieldrig up` in a process of its own, on ports that are free."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

import canopen
from canopen.profiles.p402 import BaseNode402
from canopen_network import network_on, socketcand_at
from running_rig import AskedRig, until

from fieldrig.testing import free_port
from fieldrig_devices.max4.can.objects import EDS

CONFIGS = Path(__file__).parents[2] / "configs"
IO32 = CONFIGS / "eds" / "io32.eds"
DRIVES = ("infeed", "film", "jaw", "outfeed")
AXES, PANEL = 1, 20
"""Nodes on the CAN."""


class PatientNode402(BaseNode402):
    """Gives a busy host time, and repeats a control word after a second, as ring-lab.md explains."""

    TIMEOUT_SWITCH_STATE_SINGLE = 1.0
    TIMEOUT_SWITCH_OP_MODE = TIMEOUT_SWITCH_STATE_FINAL = TIMEOUT_CHECK_TPDO = 20.0
    TIMEOUT_HOMING_DEFAULT = 30


class RingProcess(AskedRig):
    def __init__(self, file: str = "ring.yaml", *more: str) -> None:
        """`more` are further options of `up`."""
        self.can_port, self.modbus_port = free_port(), free_port()
        places = {
            "buses.can0.socketcand": f"127.0.0.1:{self.can_port}",
            "buses.modbus.listen": f"127.0.0.1:{self.modbus_port}",
        }
        sets = [word for key, place in places.items() for word in ("--set", f"{key}={place}")]
        super().__init__(CONFIGS / file, None, *sets, *more)

    @property
    def run(self) -> Path:
        return self.folder / "run" / self.file.stem

    @property
    def com1(self) -> Path:
        return self.run / "com1"

    def do(self, words: str) -> None:
        """Act as an operator at the controller."""
        self.set("max4/command", words)

    def fault(self, where: str, *words: str) -> None:
        done = self.tool("fault", where, *words)
        assert done.returncode == 0, done.stderr

    def until_up(self) -> Self:
        """The ring is in operation, and the drives' parameters have been read."""
        until(lambda: self.get("max4/ring.state") == "up")
        return self

    def rest(self) -> None:
        """Nothing is wrong, and nothing is enabled."""
        self.set("panel/6200:01", 1)
        for name in DRIVES:
            self.set(f"max4/{name}.ControllerEnable", False)

        def is_at_rest() -> bool:
            if self.get("max4/DiagCode") or self.get("max4/ring.state") == "down":
                self.do("quit")
            return (
                self.get("max4/ring.state") == "up"
                and not self.get("max4/DiagCode")
                and all(self.get(f"max4/{name}.AxisState") == 1 for name in DRIVES)
            )

        until(is_at_rest)

    def codes(self) -> list[int]:
        """Codes, oldest first."""
        return [int(line.split("\t")[5]) for line in str(self.get("max4/log")).splitlines()[::-1]]


class Plc:
    """A CANopen master, and what it has of each node."""

    def __init__(self, network: canopen.Network) -> None:
        self.network = network
        self.axes: Any = PatientNode402(AXES, str(EDS))  # type: ignore[no-untyped-call]  # as python canopen is
        network.add_node(self.axes)
        self.panel: Any = network.add_node(PANEL, str(IO32))

    def word(self, axis: int) -> int:
        """Status word of an axis, from 0 on."""
        word: int = self.axes.sdo[0x6041 + 0x800 * axis].raw
        return word

    def is_in(self, axis: int, state: int, mask: int = 0x6F) -> bool:
        return self.word(axis) & mask == state

    def enable(self, axis: int, mode: int) -> None:
        base = 0x800 * axis
        self.axes.sdo[0x6060 + base].raw = mode
        if self.is_in(axis, 0x08, 0x4F):
            self.axes.sdo[0x6040 + base].raw = 0x80
        for word, state in ((0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)):
            self.axes.sdo[0x6040 + base].raw = word
            until(lambda state=state: self.is_in(axis, state))  # type: ignore[misc]  # mypy #12557: a default in a lambda

    def disable(self, axis: int) -> None:
        self.axes.sdo[0x6040 + 0x800 * axis].raw = 0
        until(lambda: self.is_in(axis, 0x40, 0x4F))


@contextmanager
def plc_of(ring: RingProcess) -> Iterator[Plc]:
    with network_on(socketcand_at(ring.can_port)) as network:
        yield Plc(network)
