"""Controllers with modems at COM1, and laptops that call them, in virtual time."""

from collections.abc import Callable, Sequence
from typing import Any, Final

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig
from fieldrig_devices.dial.caller import Caller, Plan
from fieldrig_devices.ppp.settings import Login

MODEM_BPS: Final = 33_600
OFFLINE: Final = 6  # Com1UserState
LIMIT_NS: Final = 300 * S


def number_of(pair: int) -> str:
    return f"{4711 + pair}"


def rig_of(baud: int, *, pairs: int = 1, axes: int = 16, is_paced: bool = True) -> dict[str, Any]:
    """Return a rig with `pairs` controllers with modems, and as many laptops with modems, at one exchange."""
    buses: dict[str, Any] = {}
    devices: dict[str, Any] = {}
    numbers: dict[str, str] = {}
    pace = {} if is_paced else {"paced": False}
    for pair in range(pairs):
        plc, machine, laptop = f"max4_{pair}", f"machine_{pair}", f"laptop_{pair}"
        buses |= {name: {"kind": "serial.virtual", "baud": baud, **pace} for name in (f"com1_{pair}", f"caller_{pair}")}
        numbers |= {machine: number_of(pair), laptop: f"{4811 + pair}"}
        modem = {"kind": "modem", "baud": baud, "highest_bps": MODEM_BPS, **pace}
        devices[plc] = {
            "kind": "max4",
            "links": {"com1": f"com1_{pair}"},
            "com1": {"modem": "Modem", "baud": baud if is_paced else None},
            "drives": {f"axis{number}": {"ring_address": number, "simulated": True} for number in range(1, axes + 1)},
            "parameters": {"MAx-4.Com1User": 1, "Modem.UserName": "service", "Modem.Password": "pacdrive"},
        }
        devices[machine] = {**modem, "links": {"line": f"com1_{pair}", "telephone": "telephone"}}
        devices[laptop] = {**modem, "links": {"line": f"caller_{pair}", "telephone": "telephone"}}
    buses["telephone"] = {"kind": "telephone.virtual", "numbers": numbers, **pace}
    return {"time": "virtual", "buses": buses, "devices": devices}


class Laptop:
    """A caller at the second modem of a pair."""

    def __init__(self, rig: Rig, pair: int = 0) -> None:
        self.rig, self.pair = rig, pair
        line = rig.attach(f"terminal_{pair}").link(f"caller_{pair}")
        plan = Plan(number_of(pair), login=Login.of("service", "pacdrive"))
        self.bytes_sent = self.bytes_received = 0
        self._line = line
        self.caller = Caller(plan, lambda: 0x1234_5678 + pair, self._send, lambda _text: None)
        line.on_receive(self._on_data)

    def _send(self, data: bytes) -> None:
        self.bytes_sent += len(data)
        self._line.send(data)

    def _on_data(self, data: bytes) -> None:
        self.bytes_received += len(data)
        self.caller.receive(self.rig.now_ns, data)

    def dial(self) -> None:
        self.caller.start(self.rig.now_ns)

    @property
    def is_awaited(self) -> bool:
        """True if the controller waits for a call."""
        return bool(self.rig.get(f"max4_{self.pair}", "Com1UserState") == OFFLINE)

    def fetch(self, path: str) -> "Page":
        return Page(self, path)


class Page:
    """A page that is being fetched."""

    def __init__(self, laptop: Laptop, path: str) -> None:
        self._connection = laptop.caller.open(80)
        self.instants, self.sizes, self.content = list[int](), list[int](), bytearray()
        self.is_complete = False
        self.begun_ns = laptop.rig.now_ns
        self._connection.on_data, self._connection.on_end = self._on_data, self._on_end
        request = f"GET {path} HTTP/1.1\r\nHost: wrapper\r\nConnection: close\r\n\r\n"
        self._connection.send(request.encode())
        self._now_ns: Callable[[], int] = lambda: laptop.rig.now_ns

    @property
    def size(self) -> int:
        return sum(self.sizes)

    def _on_data(self, data: bytes) -> None:
        self.instants.append(self._now_ns())
        self.sizes.append(len(data))
        self.content += data

    def _on_end(self) -> None:
        self.is_complete = True
        self._connection.close()


def run_until(rig: Rig, laptops: Sequence[Laptop], is_done: Callable[[], bool], step_ns: int = MS) -> None:
    """Let rig and laptops go on.  RuntimeError for a call that has failed, or after a limit."""
    end_ns = rig.now_ns + LIMIT_NS
    while not is_done():
        failed = [laptop.caller.failure for laptop in laptops if laptop.caller.is_over]
        if failed or rig.now_ns > end_ns:
            raise RuntimeError(f"a call has failed: {failed}")
        rig.run_until(rig.now_ns + step_ns)
        for laptop in laptops:
            laptop.caller.advance(rig.now_ns)


def call(rig: Rig, laptops: Sequence[Laptop]) -> None:
    """Wait for the controllers, dial, and wait until all links are up."""
    run_until(rig, (), lambda: all(laptop.is_awaited for laptop in laptops))
    for laptop in laptops:
        laptop.dial()
    run_until(rig, laptops, lambda: all(laptop.caller.is_up for laptop in laptops))


def open_rig(**settings: Any) -> Rig:
    return Rig(from_dict(rig_of(**settings)))
