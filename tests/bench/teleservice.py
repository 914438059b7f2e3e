"""Teleservice: a page of the MAx-4 through modems, PPP and TCP in virtual time, against the limit of the line."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from report import COMPARED, Report, progress

from fieldrig.clock import MS, S
from fieldrig.config import from_dict
from fieldrig.rig import Rig
from fieldrig_devices.dial.caller import Caller, Plan
from fieldrig_devices.ppp.settings import Login

HERE = Path(__file__).parent
BAUDS = (38_400, 115_200)
MODEM_BPS = 33_600
OFFLINE = 6  # Com1UserState
SEGMENT, FRAME = 1460, 1460 + 20 + 20 + 8
"""Bytes of data in a full TCP segment, and of its PPP frame with TCP and IP headers."""
LIMIT_NS = 300 * S


def rig_of(baud: int) -> dict[str, Any]:
    modem = {"kind": "modem", "baud": baud, "highest_bps": MODEM_BPS}
    return {
        "time": "virtual",
        "buses": {
            "com1": {"kind": "serial.virtual", "baud": baud},
            "caller": {"kind": "serial.virtual", "baud": baud},
            "telephone": {"kind": "telephone.virtual", "numbers": {"machine": "4711", "laptop": "4712"}},
        },
        "devices": {
            "max4": {
                "kind": "max4",
                "links": {"com1": "com1"},
                "com1": {"modem": "Modem", "baud": baud},
                "drives": {f"axis{number}": {"ring_address": number, "simulated": True} for number in range(1, 17)},
                "parameters": {"MAx-4.Com1User": 1, "Modem.UserName": "service", "Modem.Password": "pacdrive"},
            },
            "machine": {**modem, "links": {"line": "com1", "telephone": "telephone"}},
            "laptop": {**modem, "links": {"line": "caller", "telephone": "telephone"}},
        },
    }


class Laptop:
    """A caller at the second modem."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        line = rig.attach("terminal").link("caller")
        plan = Plan("4711", login=Login.of("service", "pacdrive"))
        self.caller = Caller(plan, lambda: 0x1234_5678, line.send, lambda _text: None)
        line.on_receive(lambda data: self.caller.receive(rig.now_ns, data))
        self.until(lambda: rig.get("max4", "Com1UserState") == OFFLINE)
        self.caller.start(rig.now_ns)
        self.until(lambda: self.caller.is_up)

    def until(self, is_done: Callable[[], bool]) -> None:
        end_ns = self.rig.now_ns + LIMIT_NS
        while not is_done():
            if self.rig.now_ns > end_ns or self.caller.is_over:
                raise RuntimeError(f"the call has failed: {self.caller.failure}")
            self.rig.run_until(self.rig.now_ns + MS)
            self.caller.advance(self.rig.now_ns)

    def page(self, path: str) -> tuple[int, float]:
        """Fetch a page.  Returns its bytes and the seconds from the first to the last of them."""
        connection = self.caller.open(80)
        instants, sizes, ends = list[int](), list[int](), list[bool]()

        def on_data(data: bytes) -> None:
            instants.append(self.rig.now_ns)
            sizes.append(len(data))

        connection.on_data, connection.on_end = on_data, lambda: ends.append(True)
        connection.send(f"GET {path} HTTP/1.1\r\nHost: wrapper\r\nConnection: close\r\n\r\n".encode())
        self.until(lambda: bool(ends))
        connection.close()
        return sum(sizes[1:]), (instants[-1] - instants[0]) / S


def run() -> Report:
    report = Report(
        "Teleservice",
        "This table shows how fast a page comes over a call in virtual time, beside the slower of line and modems.",
        COMPARED,
    )
    for baud in BAUDS:
        progress(f"teleservice: {baud} baud")
        with Rig(from_dict(rig_of(baud), HERE)) as rig:
            size, spent_s = Laptop(rig).page("/PARAMS.HTM")
        bottleneck = min(baud / 10, MODEM_BPS / 8) * SEGMENT / FRAME
        report.add(
            f"page of {size / 1000:.0f} kB, {baud} baud, modems of {MODEM_BPS} bit/s",
            f"{size / spent_s:,.0f} byte/s",
            f"the line's limit {bottleneck:,.0f} byte/s",
            size / spent_s / bottleneck,
        )
    return report


if __name__ == "__main__":
    print(run().markdown())
