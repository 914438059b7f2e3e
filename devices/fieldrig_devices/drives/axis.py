"""One axis: position, speed and current regulator on a motor with its brake and load.

Source: manual 6578-7049 (what the regulators are for); digest PD-164.  SI units at the shaft of the motor; positions
are increments, 1 000 000 per turn (manual 6933): the set position, a whole number, minus the following error.

`Axis.go` is the reference for how a drive moves: it takes inner steps of 250 us.  `Axis.cycle` uses the fold (`fold`)
where it applies, and `go` where something is limited, the direction changes or the brake holds.  An axis without torque
and without an elastic coupling follows the closed solution of `plants.axis_model`.  An axis at rest is not computed: it
rests when another step would change nothing, to the last bit.

Dry friction and brake decelerate the motor within a step, and hold it once it is at standstill; a blocked shaft stands.
Left out: cogging, current ripple, and the voltage limit at high speed.
"""

from copy import copy
from enum import Enum
from math import tau
from typing import Final, NamedTuple

from fieldrig.clock import S
from fieldrig.shortcuts import Shortcut
from fieldrig_devices.drives.fold import FollowingCycle, Numbers, folded, following
from fieldrig_devices.drives.loops import (
    INCREMENTS,
    INNER_NS,
    INNER_S,
    RAD,
    Arrangement,
    Gains,
    Limits,
    Plant,
    most_way_of,
    plant_step,
)
from fieldrig_devices.plants.axis_model import Mechanics, State, after

FOLD: Final = Shortcut("drives.fold", "a cycle without limits is computed by one map, without its inner steps")
REST: Final = Shortcut("drives.rest", "an axis that the next inner step would not change is not computed")
HALF: Final = RAD / 2
"""Half an increment, in rad: the encoder cannot resolve it."""
CREEP: Final = RAD
"""Speed of one increment per second, in rad/s; less than that is a standstill."""
JAM_NM: Final = 1e12
"""Friction of a shaft that is blocked: more than any motor has torque."""
FAR_RAD: Final = 1000 * tau
"""Following error beyond which the set position is moved to the motor, in modes without position control."""


class Mode(Enum):
    FREE = 0
    POSITION = 1
    SPEED = 2
    TORQUE = 3


class Moment(NamedTuple):
    """An axis at one instant."""

    position: float
    """Increments."""
    speed: float
    """The speed of the motor in rad/s."""
    torque: float
    """The torque of the motor in N m."""
    error: float
    """The following error in rad."""
    twist: float
    """The angle in rad by which the load lags behind the motor."""


class Axis:
    """Position, speed and current regulator with motor, brake and load."""

    __slots__ = (
        "_brake_nm",
        "_cycle",
        "_cycle_steps",
        "_dry_nm",
        "_flow",
        "_gains",
        "_is_folded",
        "_is_jammed",
        "_lead_gain",
        "_limits",
        "_may_fold",
        "_may_rest",
        "_mechanics",
        "_mode",
        "_most_way",
        "_plant",
        "_seconds",
        "_set_value",
        "_speed_gains",
        "brake_is_on",
        "e",
        "heat",
        "i",
        "is_at_rest",
        "lead",
        "load_nm",
        "load_speed",
        "moved",
        "set_increments",
        "slow_cycles",
        "t",
        "twist",
        "v",
        "way",
        "work",
    )  # fmt: skip

    def __init__(
        self, plant: Plant, gains: Gains, limits: Limits, *, dry_nm: float = 0.0, brake_nm: float = 0.0,
        increments: int = 0, cycle_steps: int = 16,
    ) -> None:  # fmt: skip
        """`dry_nm` is the constant dry friction; `brake_nm` is added while `brake_is_on`."""
        self._dry_nm, self._brake_nm = dry_nm, brake_nm
        self.brake_is_on, self._is_jammed = brake_nm > 0, False
        self.load_nm = self.lead = self._set_value = 0.0
        self.way = self.moved = 0
        self._mode = Mode.FREE
        self.set_increments = increments
        self.e = self.v = self.i = self.t = self.twist = self.load_speed = 0.0
        self.heat = self.work = 0.0
        """Torque squared and power at the shaft, integrated over time since the last `take`, with a value a cycle."""
        self.slow_cycles = 0
        """Number of cycles that took the steps."""
        self.is_at_rest = False
        """True if the axis stays as it is until an input changes."""
        self._may_fold, self._may_rest = FOLD.is_taken, REST.is_taken
        self.arrange(plant, gains, limits, cycle_steps)

    def arrange(self, plant: Plant, gains: Gains, limits: Limits, cycle_steps: int, lead_inertia: float = 0.0) -> None:
        """Set the constants from now on.  `lead_inertia` is the inertia that the current feed-forward assumes."""
        self._seconds = seconds = cycle_steps * INNER_S
        self._lead_gain = lead_inertia * RAD / (seconds * seconds)
        self._plant, self._gains, self._limits, self._cycle_steps = plant, gains, limits, cycle_steps
        self._speed_gains = Gains(0.0, gains.kp, gains.ki, 1.0)
        self._flow = plant_step(plant)
        free, braked = (
            Mechanics(plant.inertia, plant.viscous, dry, dry, lag_s=plant.lag_s)
            for dry in (self._dry_nm, self._dry_nm + self._brake_nm)
        )
        self._mechanics = {False: free, True: braked}
        self._most_way = most_way_of(limits, cycle_steps)
        self._cycle = folded(plant, gains, limits, cycle_steps, self._dry_nm)
        self._wake()

    @property
    def arrangement(self) -> Arrangement:
        return Arrangement(self._plant, self._gains, self._limits, self._cycle_steps, self._dry_nm, self._lead_gain)

    @property
    def limits(self) -> Limits:
        return self._limits

    @property
    def gains(self) -> Gains:
        return self._gains

    @property
    def mode(self) -> Mode:
        return self._mode

    @property
    def position(self) -> float:
        """Position of the motor, in increments."""
        return self.set_increments - self.e * INCREMENTS

    @property
    def set_speed(self) -> float:
        """Set speed, in rad/s."""
        if self._mode is Mode.SPEED:
            return self._set_value
        return self.moved * RAD / (self._cycle_steps * INNER_S) if self._mode is Mode.POSITION else self.v

    # ---- commands

    def control(self, mode: Mode) -> None:
        """Switch the control mode; the set position starts at the position of the motor."""
        if mode is self._mode:
            return
        was_free = self._mode is Mode.FREE
        self._mode = mode
        self._wake()
        self.way, self.moved, self._set_value, self.lead = 0, 0, 0.0, 0.0
        self.hold_here()
        if mode in (Mode.FREE, Mode.TORQUE) or was_free:
            self.i = 0.0

    def _wake(self) -> None:
        """Call this when any state that the fast form depends on has changed."""
        self.is_at_rest = False
        is_free = not self.brake_is_on and not self._is_jammed
        self._is_folded = self._may_fold and self._mode is Mode.POSITION and is_free

    def hold_here(self) -> None:
        """Move the set position to the motor."""
        position = self.position
        self.set_increments = round(position)
        self.e = (self.set_increments - position) * RAD
        self.way, self.lead = 0, 0.0
        self.is_at_rest = False

    def put(self, increments: int) -> None:
        """Redefine the present position as `increments`; nothing moves."""
        self.set_increments, self.e = increments, 0.0
        self.is_at_rest = False

    def load(self, torque_nm: float) -> None:
        """Set the external torque at the shaft of the motor; positive torque acts backwards."""
        if torque_nm != self.load_nm:
            self.load_nm = torque_nm
            self.is_at_rest = False

    def brake(self, is_on: bool) -> None:
        if is_on is not self.brake_is_on:
            self.brake_is_on = is_on
            self._wake()

    def jam(self, is_on: bool, at: float | None = None) -> None:
        """Block the shaft, at the position `at` in increments if it is given, or release it."""
        if at is not None:
            self.e = (self.set_increments - at) * RAD
        if is_on:
            self.v = 0.0
        if is_on is not self._is_jammed:
            self._is_jammed = is_on
            self._wake()

    def follow(self, increments: int) -> None:
        """Set the set position at the end of the next cycle, modulo 2^32, as received over the ring."""
        way = (increments - self.set_increments + 0x8000_0000 & 0xFFFF_FFFF) - 0x8000_0000
        if not way and self.is_at_rest:
            return
        most = self._most_way
        self.way = way = way if -most <= way <= most else most if way > 0 else -most
        self.lead = self._lead_gain * (way - self.moved)
        self.is_at_rest = False

    def set_value(self, value: float) -> None:
        """Set the command value of the modes SPEED (rad/s) and TORQUE (N m)."""
        if value != self._set_value:
            self._set_value = value
            self.is_at_rest = False

    # ---- time

    def following(self, numbers: Numbers, *, is_published: bool) -> FollowingCycle | None:
        """Return the folded form of `cycle` and `follow` together, or None while the fold does not apply."""
        if not self._is_folded:
            return None
        return following(self.arrangement, numbers, is_published=is_published)

    def cycle(self) -> None:
        """Advance by one cycle."""
        if self.is_at_rest:
            self.heat += self.t * self.t * self._seconds
            return
        if not self._is_folded or not self._cycle(self):
            self.go(self._cycle_steps)

    def go(self, steps: int) -> None:
        """Advance by inner steps; the set position of `follow` is reached within a cycle and then stays constant."""
        self.slow_cycles += 1
        if self._mode is Mode.POSITION:
            count = min(steps, self._cycle_steps)
            self._steps(count, self._gains, self.way * RAD / (count * INNER_S))
            self.set_increments += self.way
            self.moved, self.way = self.way, 0
            if steps > count:
                self._steps(steps - count, self._gains, 0.0)
        elif self._mode is Mode.SPEED:
            self._steps(steps, self._speed_gains, self._set_value)
        elif self._mode is Mode.TORQUE or self._plant.elastic is not None:
            self._steps(steps, None, self._set_value)
        else:
            self._roll(steps * INNER_S)
        if abs(self.e) > FAR_RAD and self._mode is not Mode.POSITION:
            self.hold_here()

    def ahead(self, later_ns: int) -> Moment:
        """Return the axis as it will be `later_ns` after its last step; the axis itself does not change."""
        if self.is_at_rest or later_ns <= 0:
            return Moment(self.position, self.v, self.t, self.e, self.twist)
        return copy(self)._gone(later_ns)

    def _gone(self, later_ns: int) -> Moment:
        """Advance this copy, to any instant within or after the cycle."""
        steps, rest_ns = divmod(later_ns, INNER_NS)
        set_speed, way = 0.0, 0.0
        if self._mode is Mode.POSITION:
            count = min(steps, self._cycle_steps)
            cycle_speed = self.way * RAD / self._seconds
            self._steps(count, self._gains, cycle_speed)
            self._steps(steps - count, self._gains, 0.0)
            set_speed = cycle_speed if steps < self._cycle_steps else 0.0
            way = cycle_speed * count * INNER_S
        elif self._mode is Mode.FREE and self._plant.elastic is None:
            self._roll(later_ns / S)
            rest_ns = 0
        else:
            self.go(steps)
        rest_s = rest_ns / S
        way += set_speed * rest_s
        self.e += (set_speed - self.v) * rest_s
        return Moment(self.position + way * INCREMENTS, self.v, self.t, self.e, self.twist)

    def _roll(self, seconds: float) -> None:
        """Advance without motor torque, by the closed solution."""
        if self._is_jammed:
            self.t, self.is_at_rest = 0.0, self._may_rest
            return
        before = State(0.0, self.v, self.t)
        now = after(self._mechanics[self.brake_is_on], before, 0.0, -self.load_nm, seconds)
        self.e -= now.position
        self.v, self.t = now.speed, now.torque if abs(now.torque) > 1e-9 * self._limits.torque else 0.0
        dry = self._dry_nm + self._brake_nm * self.brake_is_on
        self.is_at_rest = self._may_rest and not self.v and not self.t and abs(self.load_nm) <= dry

    def _steps(self, steps: int, gains: Gains | None, s: float) -> None:
        """Take steps with the set speed `s`, or with the set torque `s` if there are no gains."""
        dry, u = self._dry_nm + self._brake_nm * self.brake_is_on + JAM_NM * self._is_jammed, 0.0
        take = self._stiff_steps if self._plant.elastic is None else self._elastic_steps
        while steps > 0:
            count, before = min(steps, self._cycle_steps), self.v
            u = take(count, gains, s, dry)
            self.heat += self.t * self.t * (count * INNER_S)
            self.work += self.t * (before + self.v) * (count * INNER_S / 2)
            steps -= count
        if dry and not self.v and (not s or gains is None):
            self._settle(u, gains, s, dry)

    def _stiff_steps(self, steps: int, gains: Gains | None, s: float, dry: float) -> float:
        """Return the last set torque.  Written out in full, because this loop takes most of the time."""
        most, fastest = self._limits.torque, self._limits.speed
        kv, kp, ki, ff = (gains.kv, gains.kp, gains.ki, gains.ff) if gains is not None else (0.0, 0.0, 0.0, 0.0)
        growth, base, way_s = ki * INNER_S, ff * s, s * INNER_S if kv else 0.0
        (_, wv, wt, wu, wd, wf), (_, vv, vt, vu, vd, vf), (_, _, tt, _, _, _) = self._flow
        load, lead = self.load_nm, self.lead
        e, v, i, t = self.e, self.v, self.i, self.t
        u = max(-most, min(s, most))
        for _ in range(steps):
            if gains is not None:
                is_unseen = (
                    dry and not v and not s and -HALF < e < HALF
                )  # within the resolution of the encoder, so that the axis can come to rest
                set_speed = base if is_unseen else kv * e + base
                if set_speed > fastest:
                    set_speed = fastest
                elif set_speed < -fastest:
                    set_speed = -fastest
                speed_error = set_speed - v
                u = kp * speed_error + i + lead
                if u > most:
                    u = most
                elif u < -most:
                    u = -most
                else:
                    i += growth * speed_error
            speed = vv * v + vt * t + vu * u + vd * load
            way = wv * v + wt * t + wu * u + wd * load
            if dry:
                friction = -speed / vf  # the torque that would stop the motor
                if -dry <= friction <= dry or -CREEP < speed + vf * (dry if friction > 0 else -dry) < CREEP:
                    speed = 0.0
                    way = way + wf * friction if v else 0.0
                else:
                    friction = dry if friction > 0 else -dry
                    speed += vf * friction
                    way += wf * friction
            torque = u + tt * (t - u)  # exactly u once it is there
            e += way_s - way
            v, t = speed, torque
        self.e, self.v, self.i, self.t = e, v, i, t
        return u

    def _elastic_steps(self, steps: int, gains: Gains | None, s: float, dry: float) -> float:
        most, fastest = self._limits.torque, self._limits.speed
        u = max(-most, min(s, most))
        for _ in range(steps):
            if gains is not None:
                speed_error = max(-fastest, min(gains.kv * self.e + gains.ff * s, fastest)) - self.v
                wanted = gains.kp * speed_error + self.i + self.lead
                u = max(-most, min(wanted, most))
                if u == wanted:
                    self.i += gains.ki * INNER_S * speed_error
                self.e += s * INNER_S if gains.kv else 0.0
            self._elastic_step(u, dry)
        return u

    def _elastic_step(self, u: float, dry: float) -> None:
        before = (self.v, self.t, self.twist, self.load_speed, u, self.load_nm)
        flow = self._flow
        way, speed, torque, twist, load_speed = (
            sum(a * b for a, b in zip(row[1:-1], before, strict=True)) for row in flow
        )
        friction = max(-dry, min(-speed / flow[1][-1], dry))
        effect = [row[-1] * friction for row in flow]
        speed += effect[1]
        self.e -= way + effect[0]
        self.v, self.t = speed if abs(speed) > 1e-12 else 0.0, torque
        self.twist, self.load_speed = twist + effect[3], load_speed + effect[4]

    def _settle(self, u: float, gains: Gains | None, s: float, dry: float) -> None:
        """Take the set torque as reached, and set `is_at_rest` if the next step would change nothing."""
        has_set_position = gains is not None and gains.kv != 0
        is_in_place = not has_set_position or -HALF < self.e < HALF
        if not is_in_place or self._plant.elastic is not None or abs(self.t - u) > 1e-6 * self._limits.torque:
            return
        self.t = u
        if self._may_rest and not self.lead:
            later = copy(self)
            later._stiff_steps(1, gains, s, dry)
            self.is_at_rest = (later.e, later.v, later.i, later.t) == (self.e, self.v, self.i, self.t)

    def take(self, seconds: float) -> tuple[float, float]:
        """Return mean squared torque, and energy delivered at the shaft, since the last call `seconds` ago."""
        heat, work = self.heat / seconds if seconds else 0.0, self.work
        self.heat = self.work = 0.0
        return heat, work


class IdealAxis(Axis):
    """The axis of a simulated drive (manual 3875): its position is the set position."""

    __slots__ = ()

    def following(self, numbers: Numbers, *, is_published: bool) -> None:
        """Return None: the fold does not apply."""

    def cycle(self) -> None:
        self.go(self._cycle_steps)

    def ahead(self, later_ns: int) -> Moment:
        seconds = later_ns / S
        if self._mode is Mode.POSITION:
            speed = self.way * RAD / self._seconds
            way = self.way * min(seconds / self._seconds, 1.0)
            return Moment(self.position + way, speed, self.t, self.e, self.twist)
        speed = self._set_value if self._mode is Mode.SPEED else 0.0
        return Moment(self.position + speed * seconds * INCREMENTS, speed, self.t, self.e, self.twist)

    def go(self, steps: int) -> None:
        seconds = steps * INNER_S
        self.e = self.i = self.t = 0.0
        if self._mode is Mode.POSITION:
            self.v = self.way * RAD / (min(steps, self._cycle_steps) * INNER_S)
            self.set_increments += self.way
            self.moved, self.way = self.way, 0
        else:
            self.v = self._set_value if self._mode is Mode.SPEED else 0.0
            self.set_increments += round(self.v * seconds * INCREMENTS)
