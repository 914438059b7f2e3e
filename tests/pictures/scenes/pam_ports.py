"""The start-up of a PAM through its VME DualPort: SYNCHRO, commands and acknowledges, and the state of the port."""

from collections.abc import Callable, Mapping, Sequence
from typing import Final

from tests.pictures.timing import Lane, spans, timing

from fieldrig.clock import MS
from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.language.ports import ports_of
from fieldrig_devices.pam.ports import Ports
from fieldrig_devices.pam.ports.masters.script import carry_out
from fieldrig_devices.pam.ports.masters.vme import VmeMaster
from fieldrig_devices.pam.ports.memory import Memory
from fieldrig_devices.pam.ports.vme.layout import ACKNOWLEDGE, COMMAND, SYNCHRO, Answer, Command
from fieldrig_devices.pam.runtime.item import RoutineRef

APPLICATION: Final = """
APPLICATION NAME = printer V1.00; BASIC_PAM_CYCLE = 3; END
VME DUALPORT
  SPECS
    DEFAULT_PERIOD = 10;
    MASTER_READY_TIMEOUT = NONE; MASTER_CONFIGURATION_TIMEOUT = NONE; MASTER_INACTIVITY_TIMEOUT = NONE;
  END_SPECS
  INPUT WORD_VAR DWI_Speed;
  OUTPUT FLAG_VAR DFO_Ready;
END_DUALPORT
"""
LATER: Final = 20 * MS
"""Time after which the master begins, and time that is drawn after its end."""
RESULTS: Final = {Answer.NO_ACK: "", Answer.ACK_OK: "ACK_OK", Answer.END_DEF_IN: "END_DEF_IN"}


class _Pam:
    """The ports of a PAM, sampled in each of its basic cycles."""

    thirds = 3
    cycle_number = 0

    def __init__(self) -> None:
        self.program, _ = checked(APPLICATION, "printer.pam")
        self.memory = Memory()
        self.ports = Ports(self.program, self.memory, self)
        self.samples: dict[str, list[tuple[int, str]]] = {name: [] for name in ("sync", "command", "answer", "state")}

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * 1000)):
            self._sample()  # what the master has left
            self.ports.poll(self.cycle_number * MS)
            self.cycle_number += 1

    def _sample(self) -> None:
        words, now_ns = self.memory.words, self.cycle_number * MS
        command = words[COMMAND]
        for name, label in (
            ("sync", "1" if words[SYNCHRO] else ""),
            ("command", Command(command).name if command else ""),
            ("answer", RESULTS[Answer(words[ACKNOWLEDGE])]),
            ("state", self.ports.states["DualPort"]),
        ):
            self.samples[name].append((now_ns, label))

    def touched(self, name: str) -> None:
        """Do nothing: no application waits."""

    def start_routine(self, routine: RoutineRef) -> None:
        raise AssertionError(routine)

    def report(self, code: str, details: Sequence[int] = ()) -> None:
        """Show nothing."""


def vme_start_up() -> str:
    pam = _Pam()
    pam.ports.begin(0)
    pam.run(LATER / 1e9)
    carry_out(VmeMaster(ports_of(pam.program)[0].variables).start_up(), pam.memory, pam.run)
    pam.run(LATER / 1e9)
    lanes = [
        Lane("SYNCHRO", spans(pam.samples["sync"], "bus"), "byte 22"),
        Lane("COMMAND", spans(pam.samples["command"], "bus"), "byte 24, by the master"),
        Lane("ACKNOWLEDGE", spans(pam.samples["answer"]), "byte 32, by the PAM"),
        Lane("state", spans(pam.samples["state"]), "of the port"),
    ]
    about = (
        "The master synchronises, asks for inputs, defines outputs, sends initial values, and starts the application."
    )
    return timing(lanes, 0, pam.cycle_number * MS, "Start-up of a VME DualPort", about)


PICTURES: Final[Mapping[str, Callable[[], str]]] = {"pam-vme-start": vme_start_up}
