"""The rigs with modems in tests of faults: whether a caller can call, and whether data get through."""

from functools import partial
from typing import ClassVar

from fault_choices import Injected
from faulted_machine import Effect, Machine, Table, goes_on, waits
from max4_machines import Max4Machine, diagnosis

from fieldrig.clock import MS
from fieldrig_devices.dial.caller import Caller, Plan
from fieldrig_devices.ppp.settings import Login

TELEPHONE: Table = {
    "telephone cut": waits(),
    "telephone no_dial_tone": waits(),
    "telephone busy": waits(),
    "telephone no_ringing": waits(),
    "telephone noise": waits(),
    "telephone dropout": waits(),
    "telephone slow": goes_on(),
    "telephone delay": goes_on(),
}
ANSWERS = b"ATE0S0=1\r"


class Modems(Machine):
    """docs/devices/pacdrive/modem.md: office calls machine, and what one of them writes arrives at the other."""

    file = "modems.yaml"
    table: ClassVar = {
        **TELEPHONE,
        "modem power_off": waits(),
        "modem serial_unplugged": waits(),
        "modem serial_miswired": waits(),
        "modem line_unplugged": waits(),
    }
    results: ClassVar = {
        "no_dial_tone": b"NO DIALTONE",
        "busy": b"BUSY",
        "no_ringing": b"NO CARRIER",
        "cut": b"NO DIALTONE",
    }
    """The result that the calling modem shows for a fault."""
    safe_within_s = 200.0
    looks = 0

    def begin(self) -> None:
        node = self.rig.attach("programs")
        self.lines = {name: node.link(f"{name}_com") for name in ("office", "machine")}
        self.heard = {"office": b"", "machine": b""}
        for name, line in self.lines.items():
            line.on_receive(partial(self._hear, name))
        self.lines["machine"].send(ANSWERS)
        self.wait(1)

    def works(self) -> bool:
        return self._is_answered() and self._passes("office", "machine") and self._passes("machine", "office")

    def is_safe(self, where: str) -> bool:
        """Return whether no call is up that pretends to carry data."""
        return not self.works()

    def come_back(self, injected: Injected, effect: Effect) -> None:
        said = self.results.get(injected.fault["what"])
        assert said is None or said in self.heard["office"], self.heard["office"]
        self.wait(3)
        self.lines["machine"].send(ANSWERS)  # a modem that had no power has forgotten that it answers
        self.wait(1)

    def _hear(self, name: str, data: bytes) -> None:
        self.heard[name] += data

    def _is_answered(self) -> bool:
        """Hang up, dial, and wait for the result."""
        self.wait(1.5)
        for line in self.lines.values():
            line.send(b"+++")
        self.wait(1.5)
        for line in self.lines.values():
            line.send(b"ATH\r")
        self.wait(1)
        self.heard = {"office": b"", "machine": b""}
        self.lines["office"].send(b"ATE0DT200\r")
        for _ in range(70):  # S7 is 60 s
            self.wait(1)
            if self.heard["office"].endswith(b"\r\n"):
                break
        return b"CONNECT" in self.heard["office"]

    def _passes(self, sender: str, receiver: str) -> bool:
        self.heard[receiver] = b""
        self.lines[sender].send(b"Hello")
        self.wait(2)
        return self.heard[receiver].endswith(b"Hello")


class Teleservice(Max4Machine):
    """teleservice.md: a laptop calls the controller and reads a page.  The rest is that of ring.yaml."""

    file = "teleservice.yaml"
    wheres = ("max4", "machine_modem", "caller_modem", "telephone")
    table: ClassVar = {
        **TELEPHONE,
        "max4 power_off": waits(),
        "max4 memory_lost": goes_on(diagnosis(7567)),
        "max4 overrun": goes_on(diagnosis(6507)),
        "modem power_off": waits(),
        "modem serial_unplugged": waits(),
        "modem serial_miswired": waits(),
        "modem line_unplugged": waits(),
    }
    safe_within_s = 200.0
    looks = 0

    def begin(self) -> None:
        self.boot()
        self.line = self.rig.attach("laptop").link("caller")
        self.line.on_receive(self._hear)
        self.caller = self._caller()
        self._until_offline()

    def works(self) -> bool:
        return self._page().startswith(b"HTTP/1.1 200 OK")

    def is_safe(self, where: str) -> bool:
        """Return whether the caller has no call that pretends to be one."""
        return not self._page()

    def come_back(self, injected: Injected, effect: Effect) -> None:
        """Wait until the controller has found its modem again, and acknowledge."""
        self._until_offline()
        self.acknowledge()

    def _until_offline(self) -> None:
        self.until(lambda: self.get("max4", "Com1UserState") == 6, self.back_within_s, 1)

    def _caller(self) -> Caller:
        login = Login.of("service", "pacdrive")
        return Caller(Plan("4711", login=login), lambda: 0x1234_5678, self.line.send, lambda _text: None)

    def _page(self) -> bytes:
        """Call, and return the page of the controller, or nothing."""
        self.caller = self._caller()
        self.caller.start(self.rig.now_ns)
        while not self.caller.is_up and not self.caller.is_over:
            self._go_on(100)
        arrived = bytearray()
        if self.caller.is_up:
            connection = self.caller.open(80)
            connection.on_data = arrived.extend
            connection.send(b"GET / HTTP/1.1\r\nHost: wrapper\r\nConnection: close\r\n\r\n")
            for _ in range(50):
                self._go_on(100)
                if arrived:
                    break
            self.caller.hang_up(self.rig.now_ns)
        for _ in range(100):
            self._go_on(100)
            if self.caller.is_over:
                break
        return bytes(arrived)

    def _hear(self, data: bytes) -> None:
        self.has_heard = True
        self.caller.receive(self.rig.now_ns, data)

    def _go_on(self, ms: int) -> None:
        """Let time pass, and the caller act when it is due, and when it has heard something."""
        end_ns = self.rig.now_ns + ms * MS
        while self.rig.now_ns < end_ns:
            due_ns = self.caller.next_ns()
            self.has_heard = False
            self.rig.run_until(end_ns if due_ns is None else min(end_ns, due_ns), stop=lambda: self.has_heard)
            self.caller.advance(self.rig.now_ns)
