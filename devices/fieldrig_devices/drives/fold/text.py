"""The fold as Python text: lines that read an axis, refuse a cycle that may meet a limit, or move the axis.

In the text `e v i t w l` are the states before the cycle, first as they are and then as distances from the steady
state; `new_e` and so on are the states after it.  `s` is the set speed, `a` the current feed-forward, `d` and `f` are
as in `loops`, `q` is the steady torque, `b` the steady integral part, and `r` the share of the limits that the
distances use.
"""

import struct
from collections.abc import Callable, Sequence
from typing import NamedTuple

from fieldrig import sandbox
from fieldrig.clock import S
from fieldrig_devices.drives.fold.matrix import fold
from fieldrig_devices.drives.loops import (
    INCREMENTS,
    INNER_S,
    RAD,
    Arrangement,
    Gains,
    Limits,
    MovingAxis,
    Plant,
    error_of_speed,
    most_way_of,
    speed_of_way,
)
from fieldrig_devices.drives.matrices import Row


class PublishedMotion(NamedTuple):
    """The motion of an axis' load as last published: receivers extrapolate it from here."""

    position: float
    """Position of the load at `time_ns`, in rad."""
    speed: float
    time_ns: int
    tolerance: float
    """Error of the extrapolated position, in rad, beyond which it is published again."""
    gear_ratio: float
    offset: float
    """Increments from the position of the axis to that of the shaft."""


class Numbers(NamedTuple):
    """The numbers that a cycle returns, packed."""

    expressions: tuple[str, ...]
    """Python expressions: `new_e` and so on are the new states, `target` is the set position in increments."""
    codes: str
    """Their codes for `struct`."""

    @property
    def packed(self) -> str:
        """A Python expression that packs the numbers with `pack`."""
        return f"pack({', '.join(f'({expression})' for expression in self.expressions)})"

    @property
    def pack(self) -> Callable[..., bytes]:
        return struct.Struct(f"<{self.codes}").pack


def cycle_text(plant: Plant, gains: Gains, limits: Limits, steps: int, dry_nm: float) -> str:
    """Return the function `cycle(axis)`: True after a cycle; False, with nothing changed, if the map may not hold."""
    lines = [
        "def cycle(axis):",
        *_map_lines(plant, gains, limits, steps, dry_nm, refusal="False"),
        *_store_lines(plant, steps),
    ]
    lines += ["    axis.set_increments += way", "    axis.moved, axis.way = way, 0", "    return True"]
    return "\n".join(lines)


def following_text(arrangement: Arrangement, numbers: Numbers, *, is_published: bool) -> str:
    """Return the function `following`, of the type `cycle.FollowingCycle`."""
    plant, gains, limits, steps, dry_nm, lead_gain = arrangement
    most_way = most_way_of(limits, steps)
    lines = [
        "def following(axis, wanted, most_error, now_ns, published):",
        "    if axis.is_at_rest:",
        "        return None",
        *_map_lines(plant, gains, limits, steps, dry_nm, refusal="None"),
        "    if not -most_error < new_e < most_error:",
        "        return None",
        *(_published_lines(plant.elastic is not None) if is_published else []),
        *_store_lines(plant, steps),
        "    axis.set_increments = target = axis.set_increments + way",
        "    axis.moved = way",
        "    follow = (wanted - target + 0x8000_0000 & 0xFFFF_FFFF) - 0x8000_0000",
        f"    if not {-most_way} <= follow <= {most_way}:",
        f"        follow = {most_way} if follow > 0 else {-most_way}",
        "    axis.way = follow",
        f"    axis.lead = {lead_gain!r} * (follow - way)",
        f"    return {numbers.packed}",
    ]
    return "\n".join(lines)


def _published_lines(is_elastic: bool) -> list[str]:
    """Lines that return None if the load has to be published again."""
    twist, speed = (" - new_w", "(new_l if new_w else new_v)") if is_elastic else ("", "new_v")
    load = f"((axis.set_increments + way - new_e * {INCREMENTS!r} + offset) * {RAD!r}{twist}) / gear_ratio"
    return [
        "    published_at, published_speed, published_ns, tolerance, gear_ratio, offset = published",
        f"    off = published_at + published_speed * ((now_ns - published_ns) / {S}) - {load}",
        f"    if not -tolerance <= off <= tolerance or published_speed and not {speed}:",
        "        return None",
    ]


def _map_lines(plant: Plant, gains: Gains, limits: Limits, steps: int, dry_nm: float, *, refusal: str) -> list[str]:
    """Lines that return `refusal` if a limit may be met, and otherwise compute `new_e` and so on."""
    rows_of_states, weights = fold(plant, gains, limits, steps)
    names = ["e", "v", "i", "t", "w", "l"][: len(weights)]
    bound = " + ".join(
        f"{weight!r} * ({name} if {name} > 0.0 else -{name})"
        for weight, name in zip(weights, names, strict=True)
        if weight
    )
    steady = _steady_state(plant, gains)
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


def _store_lines(plant: Plant, steps: int) -> list[str]:
    """Lines that write the new states to the axis."""
    lines = [
        f"    axis.heat += new_t * new_t * {steps * INNER_S!r}",
        f"    axis.work += new_t * (old_v + new_v) * {steps * INNER_S / 2!r}",
        *(f"    axis.{name} = new_{name}" for name in "evit"),
    ]
    if plant.elastic:
        lines += ["    axis.twist = new_w", "    axis.load_speed = new_l"]
    return lines


def _steady_state(plant: Plant, gains: Gains) -> dict[str, str]:
    """Return the expressions of those states that are not 0 at constant set speed, by name."""
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

    It may use `abs`, `max`, `min`, `round`, `others`, and the attributes of its parameter `axis` that `MovingAxis`
    names.
    """
    names = {"abs": abs, "max": max, "min": min, "round": round, **others}
    return sandbox.load(text, names, sandbox.Arithmetic({"axis": MovingAxis.__annotations__}))[name]
