"""The plant and the loops of an axis as data, and the exact motion of the plant over one inner step of 250 us.

Source: manual 6578, 6951, 7047 (position, speed and current regulator; each gives the next one its set value);
platform.md "Axis model".  In each inner step the regulators sample, then the plant moves under a constant set torque:

    set speed   = kv * e + ff * set_speed            position regulator, with speed feed-forward
    set torque  = kp * (set speed - v) + i + lead    speed regulator (PI), with current feed-forward
    T' = (set torque - T) / lag,   J v' = T - b v - d,   e' = set_speed - v

`d` is the load torque plus the dry friction, whose sign is constant while the motor keeps its direction.  With an
elastic coupling the motor drives the load through a spring.  This adds two states, the twist and the speed of the load;
then `d` acts on the load, and the dry friction `f` on the motor.

`axis` carries the steps out one by one; `fold` computes all steps of a cycle at once.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import tau
from typing import Final, NamedTuple, Protocol

from fieldrig.clock import US
from fieldrig_devices.drives.matrices import Matrix, exponential
from fieldrig_devices.drives.motor import INCREMENTS_PER_TURN

INNER_NS: Final = 250 * US
"""Length of an inner step."""
INNER_S: Final = INNER_NS / 1e9
RAD: Final = tau / INCREMENTS_PER_TURN
"""Radians per increment."""
INCREMENTS: Final = INCREMENTS_PER_TURN / tau
"""Increments per radian."""


@dataclass(frozen=True, slots=True)
class Elastic:
    """A load behind an elastic coupling; all values are referred to the shaft of the motor."""

    inertia: float
    """Inertia of the load, in kg m²."""
    stiffness: float
    """Stiffness of the coupling, in N m/rad."""
    damping: float
    """Damping of the coupling, in N m s/rad."""


@dataclass(frozen=True, slots=True)
class Plant:
    """Motor and load in SI units, referred to the shaft of the motor."""

    inertia: float
    """Inertia of the motor and of everything coupled to it rigidly."""
    viscous: float = 0.0
    lag_s: float = 0.0005
    """Time constant of the current regulator."""
    elastic: Elastic | None = None

    @property
    def all_inertia(self) -> float:
        return self.inertia + (self.elastic.inertia if self.elastic else 0.0)


@dataclass(frozen=True, slots=True)
class Gains:
    """The gains of the position and the speed regulator."""

    kv: float
    """Gain of the position regulator, in 1/s."""
    kp: float
    """Proportional gain of the speed regulator, in N m s/rad."""
    ki: float
    """Integral gain of the speed regulator, in N m/rad: kp divided by the integral time."""
    ff: float
    """Speed feed-forward; 1 leaves no following error at constant speed."""


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits of set torque, in N m, and set speed, in rad/s."""

    torque: float
    speed: float


class Arrangement(NamedTuple):
    """Everything that determines how an axis moves in a cycle, apart from its state and inputs."""

    plant: Plant
    gains: Gains
    limits: Limits
    steps: int
    """Number of inner steps in a cycle."""
    dry_nm: float
    """Dry friction of the motor."""
    lead_gain: float
    """Current feed-forward in N m per increment by which `way` differs from that of the previous cycle."""


class MovingAxis(Protocol):
    """The state and inputs of an axis, as generated code reads and writes them.

    The states are `e`, `v`, `i` and `t`; with an elastic coupling also `twist` and `load_speed`.
    """

    e: float
    """Following error, in rad."""
    v: float
    """Speed of the motor, in rad/s."""
    i: float
    """Integral part of the speed regulator, in N m."""
    t: float
    """Torque of the motor, in N m."""
    twist: float
    load_speed: float
    way: int
    """Increments that the set position moves in this cycle; 0 after it."""
    moved: int
    """Increments that the set position moved in the last cycle."""
    set_increments: int
    lead: float
    """Current feed-forward in this cycle, in N m."""
    load_nm: float
    heat: float
    """Torque squared, integrated over time."""
    work: float
    """Power at the shaft, integrated over time."""
    is_at_rest: bool


@lru_cache(maxsize=256)
def plant_step(plant: Plant) -> Matrix:
    """Return the plant's exact motion in an inner step; it takes some milliseconds, and drives of a kind share it.

    The rows are angle, speed and torque of the motor, then twist and speed of an elastic load.  The columns are the
    same states, then set torque, `d` and `f`.
    """
    size = 5 if plant.elastic else 3
    flow = [[0.0] * (size + 3) for _ in range(size + 3)]
    u, d, f = size, size + 1, size + 2
    flow[1][f] = -1 / plant.inertia
    flow[0][1] = 1.0
    flow[1][1] = -plant.viscous / plant.inertia
    flow[1][2] = 1 / plant.inertia
    flow[2][2], flow[2][u] = -1 / plant.lag_s, 1 / plant.lag_s
    if plant.elastic is None:
        flow[1][d] = -1 / plant.inertia
    else:
        elastic = plant.elastic
        flow[3][1], flow[3][4] = 1.0, -1.0
        for row, sign, inertia in ((1, -1, plant.inertia), (4, 1, elastic.inertia)):
            flow[row][3] = sign * elastic.stiffness / inertia
            flow[row][1] += sign * elastic.damping / inertia
            flow[row][4] -= sign * elastic.damping / inertia
        flow[4][d] = -1 / elastic.inertia
    return exponential([[x * INNER_S for x in row] for row in flow])[:size]


def most_way_of(limits: Limits, steps: int) -> int:
    """Return the increments that an axis moves in a cycle at its speed limit."""
    return int(limits.speed * steps * INNER_S * INCREMENTS_PER_TURN / tau)


def speed_of_way(steps: int) -> float:
    """Return the speed of one increment per cycle, in rad/s."""
    return tau / INCREMENTS_PER_TURN / (steps * INNER_S)


def error_of_speed(gains: Gains) -> float:
    """Return the following error at constant set speed, in rad per rad/s."""
    return (1 - gains.ff) / gains.kv if gains.kv else 0.0
