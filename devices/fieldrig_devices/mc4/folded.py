"""The loops and the motor as a linear map: one inner step of 250 us, and a whole cycle of them folded into one.

Source: manual 6578, 6951, 7047 (position, speed and current regulator, each the set value of the next); platform.md
"Axis model".  In each inner step the regulators sample, then the plant moves on exactly, under a steady set current:

    set speed   = kv * e + ff * set_speed            position regulator, and speed feed-forward
    set torque  = kp * (set speed - v) + i + lead    speed regulator (PI), and current feed-forward
    T' = (set torque - T) / lag,   J v' = T - b v - d,   e' = set_speed - v

`d` is the load torque with the dry friction, which keeps its sign while the motor keeps its direction.  With an elastic
coupling the motor turns the load over a spring: two more states, its twist and the speed of the load; then `d` is at
the load, and the friction `f` at the motor.  As long as
nothing is limited a cycle of n steps is M^n, whose rows are written out as Python text (five times as fast as loops
over lists).  Whether anything could have been limited on the way is seen from how far the state is from the steady one
of this set speed: `reach` bounds set torque and speeds over all steps of the cycle.
"""

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import tau
from typing import Final, NamedTuple, Protocol, cast

from fieldrig import sandbox
from fieldrig.clock import US, S
from fieldrig_devices.drives.motor import INCREMENTS_PER_TURN

INNER_NS: Final = 250 * US
INNER_S: Final = INNER_NS / 1e9
RAD: Final = tau / INCREMENTS_PER_TURN
"""Of one increment."""
INCREMENTS: Final = INCREMENTS_PER_TURN / tau
"""In one radian."""

Row = list[float]
Matrix = list[Row]


@dataclass(frozen=True, slots=True)
class Elastic:
    """A load behind a coupling, all at the shaft of the motor."""

    inertia: float
    stiffness: float
    """N m / rad."""
    damping: float
    """N m s / rad."""


@dataclass(frozen=True, slots=True)
class Plant:
    """SI units at the shaft of the motor."""

    inertia: float
    """Of what turns stiffly with the motor."""
    viscous: float = 0.0
    lag_s: float = 0.0005
    """Of the current regulator."""
    elastic: Elastic | None = None

    @property
    def all_inertia(self) -> float:
        return self.inertia + (self.elastic.inertia if self.elastic else 0.0)


@dataclass(frozen=True, slots=True)
class Gains:
    kv: float
    """1/s."""
    kp: float
    """N m s / rad."""
    ki: float
    """N m / rad: kp over the integral time."""
    ff: float
    """Of the set speed; 1 leaves no following error at steady speed."""


# order of the states: e, v, i, T, then twist and speed of the load; of the inputs: set_speed, d, lead, and f
E, V, INTEGRAL, T, TWIST, LOAD = range(6)
SET_SPEED, D, LEAD, FRICTION = range(4)


def product(a: Matrix, b: Matrix) -> Matrix:
    columns = list(zip(*b, strict=True))
    return [[sum(x * y for x, y in zip(row, column, strict=True)) for column in columns] for row in a]


def identity(size: int) -> Matrix:
    return [[float(i == j) for j in range(size)] for i in range(size)]


def exponential(a: Matrix) -> Matrix:
    """By scaling, Taylor's series and squaring."""
    largest = max(sum(map(abs, row)) for row in a)
    halvings = 0
    while largest > 0.25:
        largest, halvings = largest / 2, halvings + 1
    scaled = [[x / 2**halvings for x in row] for row in a]
    total, term = identity(len(a)), identity(len(a))
    for order in range(1, 14):
        term = [[x / order for x in row] for row in product(term, scaled)]
        total = [[x + y for x, y in zip(*rows, strict=True)] for rows in zip(total, term, strict=True)]
    for _ in range(halvings):
        total = product(total, total)
    return total


def moved(plant: Plant) -> Matrix:
    """Way, speed, torque (and twist and speed of the load) after an inner step; columns: those, set torque, d, f."""
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


def step_matrix(plant: Plant, gains: Gains) -> Matrix:
    """States and inputs to states, over one inner step; square, the inputs stay."""
    states, inputs = (6, 4) if plant.elastic else (4, 3)
    way, speed, torque, *rest = moved(plant)
    size = states + inputs
    # set torque and the integrator's growth, as rows over states and inputs
    set_torque = [0.0] * size
    set_torque[E], set_torque[V], set_torque[INTEGRAL] = gains.kp * gains.kv, -gains.kp, 1.0
    set_torque[states + SET_SPEED], set_torque[states + LEAD] = gains.kp * gains.ff, 1.0
    growth = [0.0] * size
    growth[E], growth[V] = gains.ki * gains.kv * INNER_S, -gains.ki * INNER_S
    growth[states + SET_SPEED] = gains.ki * gains.ff * INNER_S

    def row_of(plant_row: Row) -> Row:
        row = [plant_row[-3] * x for x in set_torque]
        row[V] += plant_row[1]
        row[T] += plant_row[2]
        if states == 6:
            row[TWIST] += plant_row[3]
            row[LOAD] += plant_row[4]
            row[states + FRICTION] += plant_row[-1]
        row[states + D] += plant_row[-2]
        return row

    error = [-x for x in row_of(way)]
    error[E] += 1.0
    error[states + SET_SPEED] += INNER_S
    growth[INTEGRAL] += 1.0
    rows = [error, row_of(speed), growth, row_of(torque), *(row_of(one) for one in rest)]
    return rows + identity(size)[states:]


def set_torque_row(gains: Gains, states: int) -> Row:
    row = [0.0] * states
    row[E], row[V], row[INTEGRAL] = gains.kp * gains.kv, -gains.kp, 1.0
    return row


def reach(step: Matrix, states: int, steps: int, row: Row) -> Row:
    """How far each state's distance from the steady one can bring `row` times the state, in any of the steps."""
    free = [one[:states] for one in step[:states]]
    power, most = identity(states), [0.0] * states
    for _ in range(steps + 1):
        now = product([row], power)[0]
        most = [max(a, abs(b)) for a, b in zip(most, now, strict=True)]
        power = product(free, power)
    return most


@dataclass(frozen=True, slots=True)
class Limits:
    torque: float
    speed: float


class Moving(Protocol):
    """What a folded cycle reads and writes; the states are `e`, `v`, `i` and `t`, and behind a coupling two more."""

    e: float
    v: float
    i: float
    t: float
    twist: float
    load_speed: float
    way: int
    """Increments that the set position goes in this cycle; then 0."""
    moved: int
    """That it went."""
    set_increments: int
    lead: float
    load_nm: float
    heats: float
    """Torque squared, summed up over the cycles."""
    works: float
    """Torque times speed."""
    is_at_rest: bool


Cycle = Callable[[Moving], bool]
"""One cycle further; False, and nothing is done, if a limit may be met on the way."""


class Course(NamedTuple):
    """What others were told of where the load of an axis is, and how it moves: they reckon with it."""

    position: float
    """Of the load, in rad, at `time_ns`."""
    speed: float
    time_ns: int
    tolerance: float
    """Rad by which the load may be elsewhere before they have to be told anew."""
    gear_ratio: float
    offset: float
    """Increments from the axis to the shaft."""


Following = Callable[[Moving, int, float, int, Course | None], bytes | None]
"""One cycle further, and then told to follow this set position, modulo 2^32: the numbers that were asked for, packed.

None, and nothing is done, at rest, if a limit may be met, if the following error comes to the third argument, in rad,
or if the load is not where the course says for the instant of the fourth (nanoseconds)."""


class Arrangement(NamedTuple):
    """What an axis is made of, and goes by, cycle for cycle."""

    plant: Plant
    gains: Gains
    limits: Limits
    steps: int
    """In a cycle."""
    dry_nm: float
    lead_gain: float
    """Set torque, in N m, per increment by which the way of a cycle is longer than that of the one before."""


class Numbers(NamedTuple):
    """What of a cycle is to be told."""

    expressions: tuple[str, ...]
    """In Python: `new_e` and so on are the new states, `place` is the set position in increments."""
    codes: str
    """For `struct`."""

    @property
    def packed(self) -> str:
        """An expression for their bytes, with `pack`."""
        return f"pack({', '.join(f'({expression})' for expression in self.expressions)})"

    @property
    def pack(self) -> Callable[..., bytes]:
        return struct.Struct(f"<{self.codes}").pack


@lru_cache(maxsize=256)
def folded(plant: Plant, gains: Gains, limits: Limits, steps: int, dry_nm: float = 0.0) -> Cycle:
    """Drives with the same motor and load share it: it takes some milliseconds.

    With dry friction the direction must not change within a cycle.
    """
    lines = ["def cycle(axis):", *_moving(plant, gains, limits, steps, dry_nm, refusal="False"), *_kept(plant)]
    lines += ["    axis.set_increments += way", "    axis.moved, axis.way = way, 0", "    return True"]
    return cast(Cycle, compiled("\n".join(lines), "cycle"))


@lru_cache(maxsize=256)
def following(arrangement: Arrangement, numbers: Numbers, *, is_told: bool) -> Following:
    """`folded` and what comes after it, in one.  `is_told`: there is a course, and the load has to keep to it."""
    checks = _course_lines(arrangement.plant.elastic is not None) if is_told else []
    lines = ["def following(axis, wanted, most_error, now_ns, course):", *_following_lines(arrangement, checks)]
    lines.append(f"    return {numbers.packed}")
    return cast(Following, compiled("\n".join(lines), "following", pack=numbers.pack))


def _following_lines(arrangement: Arrangement, checks: Sequence[str] = ()) -> list[str]:
    """From `axis`, `wanted` and `most_error` to the new states; None is returned if the map doesn't hold.

    `checks` are lines that may return before anything has changed; `new_e` and so on are known there.
    """
    plant, gains, limits, steps, dry_nm, lead_gain = arrangement
    most_way = most_way_of(limits, steps)
    return [
        "    if axis.is_at_rest:",
        "        return None",
        *_moving(plant, gains, limits, steps, dry_nm, refusal="None"),
        "    if not -most_error < new_e < most_error:",
        "        return None",
        *checks,
        *_kept(plant),
        "    axis.set_increments = place = axis.set_increments + way",
        "    axis.moved = way",
        "    follow = (wanted - place + 0x8000_0000 & 0xFFFF_FFFF) - 0x8000_0000",
        f"    if not {-most_way} <= follow <= {most_way}:",
        f"        follow = {most_way} if follow > 0 else {-most_way}",
        "    axis.way = follow",
        f"    axis.lead = {lead_gain!r} * (follow - way)",
    ]


def _course_lines(is_elastic: bool) -> list[str]:
    """None is returned if what was told of the load holds no longer."""
    twist, speed = (" - new_w", "(new_l if new_w else new_v)") if is_elastic else ("", "new_v")
    load = f"((axis.set_increments + way - new_e * {INCREMENTS!r} + offset) * {RAD!r}{twist}) / gear_ratio"
    return [
        "    told_at, told_speed, told_ns, tolerance, gear_ratio, offset = course",
        f"    astray = told_at + told_speed * ((now_ns - told_ns) / {S}) - {load}",
        f"    if not -tolerance <= astray <= tolerance or told_speed and not {speed}:",
        "        return None",
    ]


def most_way_of(limits: Limits, steps: int) -> int:
    """Increments in a cycle, at the highest speed."""
    return int(limits.speed * steps * INNER_S * INCREMENTS_PER_TURN / tau)


def speed_of_way(steps: int) -> float:
    """rad/s of one increment in a cycle."""
    return tau / INCREMENTS_PER_TURN / (steps * INNER_S)


def error_of_speed(gains: Gains) -> float:
    """The following error that is left at a steady set speed, in rad for a rad/s."""
    return (1 - gains.ff) / gains.kv if gains.kv else 0.0


def _moving(plant: Plant, gains: Gains, limits: Limits, steps: int, dry_nm: float, *, refusal: str) -> list[str]:
    """The states after a cycle, as `new_e` and so on."""
    rows_of_states, weights = fold(plant, gains, limits, steps)
    names = ["e", "v", "i", "t", "w", "l"][: len(weights)]
    bound = " + ".join(
        f"{weight!r} * ({name} if {name} > 0.0 else -{name})"
        for weight, name in zip(weights, names, strict=True)
        if weight
    )
    steady = _steady(plant, gains)
    rows = {
        name: " + ".join([_sum(row, names), *([steady[name]] if name in steady else [])])
        for name, row in zip(names, rows_of_states, strict=True)
    }
    lines = [
        "    e, v, i, t = axis.e, (old_v := axis.v), axis.i, axis.t",
        "    way, a, d = axis.way, axis.lead, axis.load_nm",
        f"    s = way * {speed_of_way(steps)!r}",
    ]
    if plant.elastic:
        lines += ["    w, l = axis.twist, axis.load_speed", f"    f = {dry_nm!r} if v > 0.0 else {-dry_nm!r}"]
    elif dry_nm:
        lines.append(f"    d += {dry_nm!r} if v > 0.0 else {-dry_nm!r}")
    lines += [
        f"    q = {plant.viscous!r} * s + d{' + f' if plant.elastic else ''}",
        "    b = q - a",
        *(f"    {name} -= {value}" for name, value in steady.items()),
        f"    r = {bound}",
        f"    n, m = {limits.torque!r} * (1.0 - r), {limits.speed!r} * (1.0 - r)",
        "    if q > n or q < -n or s > m or s < -m:",
        f"        return {refusal}",
    ]
    if dry_nm:
        lines += [f"    if {limits.speed!r} * r >= abs(s):", f"        return {refusal}"]
    return lines + [f"    new_{name} = {rows[name]}" for name in names]


def _kept(plant: Plant) -> list[str]:
    lines = [
        "    axis.works += new_t * old_v",
        "    axis.heats += new_t * new_t",
        *(f"    axis.{name} = new_{name}" for name in "evit"),
    ]
    if plant.elastic:
        lines += ["    axis.twist = new_w", "    axis.load_speed = new_l"]
    return lines


@lru_cache(maxsize=256)
def fold(plant: Plant, gains: Gains, limits: Limits, steps: int) -> tuple[Matrix, Row]:
    """Of all steps together: what the states come to, and what part of a limit their distances may take up."""
    states = 6 if plant.elastic else 4
    step = step_matrix(plant, gains)
    power = identity(len(step))
    for _ in range(steps):
        power = product(step, power)
    return [row[:states] for row in power[:states]], _weights(plant, gains, limits, step, steps)


def _weights(plant: Plant, gains: Gains, limits: Limits, step: Matrix, steps: int) -> Row:
    """What part of a limit each state's distance from the steady one can take up in any of the steps."""
    states = 6 if plant.elastic else 4
    torque = reach(step, states, steps, set_torque_row(gains, states))
    speed = reach(step, states, steps, [float(place == V) for place in range(states)])
    wish = reach(step, states, steps, [gains.kv if place == E else 0.0 for place in range(states)])
    if plant.elastic:
        load = reach(step, states, steps, [float(place == LOAD) for place in range(states)])
        speed = [max(pair) for pair in zip(speed, load, strict=True)]
    return [
        max(a / limits.torque, b / limits.speed, c / limits.speed) for a, b, c in zip(torque, speed, wish, strict=True)
    ]


def _steady(plant: Plant, gains: Gains) -> dict[str, str]:
    """The state in which this set speed stays as it is, where it isn't 0; the map turns the distance from it."""
    left = error_of_speed(gains)
    states = {"v": "s", "i": "b", "t": "q"}
    if left:
        states["e"] = f"{left!r} * s"
    if plant.elastic:
        states |= {"w": f"d / {plant.elastic.stiffness!r}", "l": "s"}
    return states


def _sum(row: Row, names: Sequence[str]) -> str:
    return " + ".join(f"{factor!r} * {name}" for factor, name in zip(row, names, strict=True))


def compiled(text: str, name: str, **others: Callable[..., object]) -> Callable[..., object]:
    """Return the function `name` of generated text, checked by the kernel's sandbox.

    It sees `abs`, `max`, `min`, `round`, `others`, and those attributes of its parameter `axis` that `Moving` names.
    """
    names = {"abs": abs, "max": max, "min": min, "round": round, **others}
    return sandbox.load(text, names, sandbox.Arithmetic({"axis": Moving.__annotations__}))[name]
