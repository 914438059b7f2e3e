"""The fold: the fast form of a drive's cycle, which computes all inner steps of a cycle at once.

**The reference** is `axis.Axis.go` in `drives/axis.py`.  It carries a cycle out in inner steps of 250 us: the
regulators sample, the plant moves, limits, dry friction and brake apply.  How a drive moves
is defined there and nowhere else.

**What the fold is.**  While nothing is limited, an inner step is linear: a matrix M maps the state and the inputs of
the axis to its next state.  A cycle of n steps is then the matrix power M^n (`matrix`), whose rows are written out as
Python text (`text`) and compiled once per arrangement of plant, gains and limits (`cycle`).  Straight-line code is
five times as fast as loops over lists, and drives with the same motor and load share it.

**When it applies.**  The axis follows a set position, its brake is lifted, and no step of the cycle can meet a limit or
change the direction of the motor.  `matrix` derives a bound for that from the distance between the state and the steady
state of the present set speed: how much of the torque and speed limits this distance can use in any step.  If the bound
does not rule a limit out, the generated function changes nothing and refuses, and the axis takes the steps.

**What it may not change.**  The state after a folded cycle is the state after the steps, up to the rounding of floating
point numbers: some 1e-13 of a value after many cycles.  What a drive sends, publishes and shows is the same either way,
to the last bit, because all of it is rounded to units that are coarser by some orders of magnitude (`GUARD` and
`DECIMALS` of an MC-4).  `tests/devices/drives/test_axis.py` compares the two for random states;
`tests/devices/mc4/test_shortcuts.py` compares what whole lines of drives say.
"""

from fieldrig_devices.drives.fold.cycle import FollowingCycle, folded, following
from fieldrig_devices.drives.fold.text import Numbers, PublishedMotion, compiled

__all__ = ["FollowingCycle", "Numbers", "PublishedMotion", "compiled", "folded", "following"]
