"""The labelling machine of the PAM: its start, and the first print marks."""

from collections.abc import Callable, Mapping
from typing import Final

from tests.pictures.chart import chart
from tests.pictures.recording import recorded

from fieldrig.clock import MS, S
from fieldrig.virtual.rig import Rig

IDLE: Final = 2
STEP_NS: Final = 10 * MS
BEFORE_NS: Final = 500 * MS
SHOWN_S: Final = 10.0
MM_A_TURN: Final = 100.0
DEGREES_A_TURN: Final = 360.0


def start() -> str:
    """Speeds of belt, knife and web while the machine starts, and the web's correction at its first marks."""
    belt: list[tuple[float, float]] = []
    knife: list[tuple[float, float]] = []
    web: list[tuple[float, float]] = []

    def play(rig: Rig) -> None:
        while rig.get("plc", "DOW_State") != IDLE:
            rig.run_until(rig.now_ns + 100 * MS)
        begin_ns = rig.now_ns
        rig.run_until(begin_ns + BEFORE_NS)
        rig.set("plc", "DIF_Start", True)
        while (now_s := (rig.now_ns - begin_ns) / S) <= SHOWN_S:
            belt.append((now_s, float(rig.get("belt", "set_speed")) * MM_A_TURN))
            knife.append((now_s, float(rig.get("cutter", "set_speed")) * DEGREES_A_TURN))
            web.append((now_s, float(rig.get("paper", "set_speed")) * MM_A_TURN))
            rig.run_until(rig.now_ns + STEP_NS)

    recorded("pam-machine.yaml", play)
    about = "Belt, knife and web follow one master; the web moves by another 16 mm after the first print marks."
    curves = {"belt, mm/s": belt, "knife, degrees/s": knife, "web, mm/s": web}
    return chart(curves, 1_200.0, "s", "", "A start of the labelling machine", about)


PICTURES: Final[Mapping[str, Callable[[], str]]] = {"pam-machine-start": start}
