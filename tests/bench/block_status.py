"""Block status in real time: how late Done arrives after the last pulse, with two pulse outputs busy."""

import sys
import time
from pathlib import Path

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from report import COMPARED, Report, percentile, progress  # noqa: E402  found beside this file
from running_rig import RunningRig  # noqa: E402

MAST_MS = 10
MEASURED_S = 20.0
MOVER = """
PROGRAM PLC_PRG
VAR
    bDone AT %QX0.0 : BOOL;
    Move : PTOMoveRelative;
END_VAR
PTO00();
Move(PTO_REF_IN := PTO00.PTO_REF, Execute := NOT bDone, Velocity := 50000, Distance := 5000, Acceleration := 20,
    Deceleration := 20, Direction := PTO_POSITIVE);
bDone := Move.Done;
END_PROGRAM
"""
CONTROLLER = """
  {0}:
    kind: hmiscu
    links: {{wires: wires}}
    channel_0: {{mode: pto}}
    terminals: {{FQ0: {0}.pulse, DQ0: {0}.done}}
    program: mover.st
  watch_{0}:
    kind: "block_status_kinds:StatusWatch"
    links: {{wires: wires}}
    pulses: {0}.pulse
    status: {0}.done
"""
RIG = "time: real\nbuses: {wires: {kind: wires.hub}}\ndevices:\n" + CONTROLLER.format("a") + CONTROLLER.format("b")


class Movers(RunningRig):
    def __init__(self) -> None:
        super().__init__(RIG, HERE / "block_status_kinds.py")

    def up(self, *options: str) -> object:  # type: ignore[override]
        (self.folder / "mover.st").write_text(MOVER)
        return super().up(*options)


def run() -> Report:
    progress("block status: two pulse outputs")
    with Movers() as rig:
        rig.until_ready()
        time.sleep(MEASURED_S)
        late_ms = [[int(word) / 1e6 for word in str(rig.value(f"watch_{name}/late_ns")).split()] for name in ("a", "b")]
    report = Report(
        "Block status in real time",
        "Two HMISCUs, each in a process of its own, move 5,000 pulses at 50 kHz again and again for "
        f"{MEASURED_S:.0f} s.  A process beside them compares the instant at which the wire of the pin Done arrives "
        "with the exact end of the pulses.  MAST shows Done in its next cycle, so "
        f"up to {MAST_MS} ms are the share of the controller.",
        COMPARED,
    )
    found = late_ms[0] + late_ms[1]
    for percent in (50, 99, 100):
        late = percentile(found, percent)
        name = f"Done, {percent} % of {len(found)} moves" if percent < 100 else f"Done, latest of {len(found)} moves"
        report.add(name, f"{late:.2f} ms", f"a MAST cycle of {MAST_MS} ms", late / MAST_MS)
    return report


if __name__ == "__main__":
    print(run().markdown())
