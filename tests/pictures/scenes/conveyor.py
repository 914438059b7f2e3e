"""The conveyor: a run of its belt from the start cam to the stop cam."""

from collections.abc import Callable, Mapping
from typing import Final

from tests.pictures.chart import chart
from tests.pictures.recording import recorded

from fieldrig.clock import MS, S
from fieldrig.virtual.rig import Rig

S1_ON, S1_OFF = 3, 1
PART_MM: Final = 200.0
STEP_NS: Final = 4 * MS
SHOWN_S: Final = 4.0


def run() -> str:
    """The master within its part, and the belt, in a run of start cam, straight lines and stop cam."""
    master: list[tuple[float, float]] = []
    belt: list[tuple[float, float]] = []

    def play(rig: Rig) -> None:
        while not rig.get("max4", "booted"):
            rig.run_until(rig.now_ns + S)
        rig.run_until(rig.now_ns + S)
        rig.set("panel", "6200:01", S1_ON)
        while not rig.get("max4", "MasterEncoder.Velocity"):
            rig.run_until(rig.now_ns + MS)
        rig.set("panel", "6200:01", S1_OFF)
        begin_ns = rig.now_ns
        while (now_s := (rig.now_ns - begin_ns) / S) <= SHOWN_S:
            master.append((now_s, float(rig.get("max4", "MasterEncoder.Position")) % PART_MM))
            belt.append((now_s, max(float(rig.get("line", "speed")) * 1000, 0.0)))
            rig.run_until(rig.now_ns + STEP_NS)

    recorded("conveyor.yaml", play)
    about = "The belt follows a start cam, two straight lines and a stop cam; its speed does not jump where they join."
    curves = {"speed of the belt, mm/s": belt, "master in its part, mm": master}
    return chart(curves, 300.0, "s", "", "A run of the belt", about)


PICTURES: Final[Mapping[str, Callable[[], str]]] = {"conveyor-run": run}
