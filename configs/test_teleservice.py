"""Teleservice in virtual time: a laptop dials the wrapper, logs in, and reads a page of its controller."""

from pathlib import Path

from fieldrig import MS, Rig, RigMaker, S
from fieldrig_devices.dial import Caller, Login, Plan

RIG = Path(__file__).with_name("teleservice.yaml")
MODEM_OFFLINE, MODEM_ONLINE = 6, 7  # Com1UserState
LOGIN = Login.of("service", "pacdrive")


class Laptop:
    """A laptop at the caller's modem."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.said: list[str] = []
        self._line = rig.attach("laptop").link("caller")
        self._line.on_receive(lambda data: self.caller.receive(rig.now_ns, data))
        self.caller = self._new(LOGIN)

    def call(self, login: Login = LOGIN) -> "Laptop":
        """Dial, and wait until the link is up, or the call has failed."""
        self.caller = self._new(login)
        self.caller.start(self.rig.now_ns)
        while not self.caller.is_up and not self.caller.is_over:
            self.run(100)
        return self

    def run(self, ms: int) -> None:
        end_ns = self.rig.now_ns + ms * MS
        while self.rig.now_ns < end_ns:
            due_ns = self.caller.next_ns()
            self.rig.run_until(min(end_ns, max(due_ns or end_ns, self.rig.now_ns), self.rig.now_ns + MS))
            self.caller.advance(self.rig.now_ns)

    def page(self, path: str) -> bytes:
        """Return a page of the controller."""
        connection = self.caller.open(80)
        arrived, ends = bytearray(), list[bool]()
        connection.on_data, connection.on_end = arrived.extend, lambda: ends.append(True)
        connection.send(f"GET {path} HTTP/1.1\r\nHost: wrapper\r\nConnection: close\r\n\r\n".encode())
        while not ends and not self.caller.is_over:
            self.run(100)
        connection.close()
        self.run(500)
        return bytes(arrived)

    def _new(self, login: Login) -> Caller:
        return Caller(Plan("4711", login=login), lambda: 0x1234_5678, self._line.send, self.said.append)


def ready(make: RigMaker) -> Laptop:
    rig = make(RIG)
    rig.until(lambda: rig.get("max4/Com1UserState") == MODEM_OFFLINE, within=60 * S)
    return Laptop(rig)


def test_a_laptop_dials_and_reads_a_page(fieldrig_rig: RigMaker) -> None:
    laptop = ready(fieldrig_rig).call()
    assert laptop.rig.get("max4/Com1UserState") == MODEM_ONLINE
    page = laptop.page("/AXES.HTM")
    assert page.startswith(b"HTTP/1.1 200 OK\r\n")
    assert all(b">%s</td>" % axis in page for axis in (b"infeed", b"film", b"jaw", b"outfeed"))
    laptop.caller.hang_up(laptop.rig.now_ns)
    laptop.run(8000)
    assert laptop.rig.get("max4/Com1UserState") == MODEM_OFFLINE


def test_a_wrong_password_is_refused(fieldrig_rig: RigMaker) -> None:
    laptop = ready(fieldrig_rig).call(Login.of("service", "wrong"))
    assert laptop.caller.failure is not None
    assert laptop.caller.failure.what == "The controller refuses the user name or the password."


def test_a_line_that_is_cut_can_be_dialled_again(fieldrig_rig: RigMaker) -> None:
    laptop = ready(fieldrig_rig).call()
    fault = laptop.rig.add_fault("machine_modem", {"what": "power_off"})
    laptop.run(3000)
    assert laptop.rig.get("max4/Com1UserState") != MODEM_ONLINE
    laptop.rig.clear_fault("machine_modem", fault)
    while laptop.rig.get("max4/Com1UserState") != MODEM_OFFLINE:
        laptop.run(1000)
    assert laptop.call().page("/").startswith(b"HTTP/1.1 200 OK\r\n")
