"""A roll, a span of elastic web and a dancer between it and the line, in steps of about a millisecond.

    J dw/dt = sense (T - R F) - b w - dry sign(w)        sense: 1 rewinder, -1 unwinder
    M dq/dt = P - k p - c q - n F                        p, q: position and speed of the dancer, n strands
    F = E A (e + damping de/dt), not below 0             e = x / s: the way is x longer than its unstretched web s

`s` is the incoming minus the outgoing web, both unstretched, so no web is lost; the radius grows by one
thickness a turn.  Web that comes to or leaves a roll carries its share of momentum, so dJ/dt adds no torque.

Each step is the implicit midpoint rule: the mean tension of the step is found from the speeds that it causes, which is
one linear equation.  It is stable at any step, adds no damping, and is of second order; only vibration faster than the
step is inexact.  A step in which dry friction stops the roll is divided there.
Left out: the inertia of other rollers, air between the layers, slip, out-of-round rolls.
"""

import math
from math import tau
from typing import Final, NamedTuple

from fieldrig_devices.plants.winder_settings import WinderSettings

MOST_DRAWN_OUT: Final = 1_000.0
"""Ratio of the length of the path to the unstretched web in it at which any web breaks."""


class _Affine(NamedTuple):
    """A mean speed over the step: without tension, and its decrease per N of tension."""

    free: float
    per_n: float = 0.0


class _Means(NamedTuple):
    """Mean tension and mean speed of the dancer over a step."""

    tension: float
    dancer: float


class WinderModel:
    """The state of roll, web and dancer."""

    def __init__(self, settings: WinderSettings) -> None:
        self._settings = settings
        self._stiffness_n, self._damping_s = settings.stiffness_n, settings.damping_s
        self._viscous = settings.viscous_nm_s_per_rad
        self._sense = 1 if settings.role == "rewinder" else -1
        self.angle = self.speed = 0.0
        self.mount(settings.initial_radius_m)
        dancer = settings.dancer
        self._strands = 0 if dancer is None else dancer.strands
        self.dancer_m = 0.0 if dancer is None else dancer.initial_m
        self.dancer_speed = 0.0
        self.dancer_force_n = 0.0 if dancer is None else dancer.force_n
        self.is_broken = False
        self.span_m = self._way / (1 + settings.initial_tension_n / self._stiffness_n)
        """Length of the unstretched web in the span."""

    @property
    def _way(self) -> float:
        return self._settings.span_m + self._strands * self.dancer_m

    @property
    def stretch_m(self) -> float:
        """Length of the path minus that of the unstretched web in it; negative if the web is slack."""
        return self._way - self.span_m

    def mount(self, radius_m: float) -> None:
        """Mount a roll of this radius."""
        self.radius_m = radius_m
        self.inertia = self._settings.inertia_kg_m2(radius_m)

    def break_web(self) -> None:
        self.is_broken = True

    def thread_web(self) -> None:
        """Thread a new web through the span, without tension, for which the roll is stopped."""
        self.is_broken, self.speed = False, 0.0
        self.span_m = self._way

    def tension(self, line_speed: float) -> float:
        stretch = self.stretch_m
        if self.is_broken or stretch <= 0:
            return 0.0
        roll_share, line_share = self._shares(stretch)
        rate = self._sense * (self.speed * self.radius_m * roll_share - line_speed * line_share)
        rate += self._strands * self.dancer_speed
        return max(0.0, self._stiffness_n * (stretch + self._damping_s * rate) / self.span_m)

    def acceleration(self, tension: float, torque: float, dry: float) -> float:
        """Return the present acceleration of the roll."""
        push = self._sense * (torque - self.radius_m * tension)
        if not self.speed and abs(push) <= dry:
            return 0.0
        push -= math.copysign(dry, self.speed or push)
        return (push - self._viscous * self.speed) / self.inertia

    def dancer_acceleration(self, tension: float) -> float:
        dancer = self._settings.dancer
        if dancer is None:
            return 0.0
        force = self.dancer_force_n - dancer.spring_n_per_m * self.dancer_m - self._strands * tension
        is_held = self.dancer_m <= 0 if force < 0 else self.dancer_m >= dancer.travel_m
        return 0.0 if is_held else (force - dancer.damping_n_s_per_m * self.dancer_speed) / dancer.mass_kg

    def step(self, seconds: float, torque: float, dry: float, line_m: float) -> None:
        """Advance while `line_m` of web passes; positive torque pulls the web tight, `dry` holds the roll."""
        speed, half = self.speed, seconds / 2
        inertia = self.inertia
        yields = inertia + half * self._viscous
        per_n = half * self.radius_m / yields * self._sense

        def rolling(sign: float) -> _Affine:
            return _Affine((inertia * speed + half * (self._sense * torque - dry * sign)) / yields, per_n)

        sign = math.copysign(1.0, speed)
        if not speed and dry:
            means = self._means(_Affine(0.0), seconds, line_m)
            push = self._sense * (torque - self.radius_m * means.tension)
            if abs(push) <= dry:
                self._move(seconds, 0.0, means, line_m)
                return
            sign = math.copysign(1.0, push)
        roll = rolling(sign)
        means = self._means(roll, seconds, line_m)
        mean = roll.free - roll.per_n * means.tension
        then = 2 * mean - speed
        if dry and then * sign < 0:
            part = speed / (speed - then)  # share of the step until standstill
            mean = speed / 2
            if 0 < part < 1:
                means = self._means(_Affine(mean), seconds * part, line_m * part)
                self._move(seconds * part, mean, means, line_m * part)
                self.speed = 0.0
                self.step(seconds * (1 - part), torque, dry, line_m * (1 - part))
                return
            means = self._means(_Affine(mean), seconds, line_m)
        self._move(seconds, mean, means, line_m)

    def _shares(self, stretch: float) -> tuple[float, float]:
        """Return the unstretched share of web at the roll and at the line; web leaves the span stretched."""
        out = 1 / (1 + max(0.0, stretch) / self.span_m)
        return (out, 1.0) if self._sense > 0 else (1.0, out)

    def _means(self, roll: _Affine, seconds: float, line_m: float) -> _Means:
        """Return the means over the step; at its stops the dancer moves as far as it can."""
        dancer = self._dancer(seconds)
        tension = self._mean_tension(roll, dancer, seconds, line_m)
        speed = dancer.free - dancer.per_n * tension
        settings = self._settings.dancer
        if settings is not None and not 0 <= self.dancer_m + speed * seconds <= settings.travel_m:
            speed = ((0 if speed < 0 else settings.travel_m) - self.dancer_m) / seconds
            tension = self._mean_tension(roll, _Affine(speed), seconds, line_m)
        return _Means(tension, speed)

    def _dancer(self, seconds: float) -> _Affine:
        dancer, half = self._settings.dancer, seconds / 2
        if dancer is None:
            return _Affine(0.0)
        yields = dancer.mass_kg + half * (dancer.damping_n_s_per_m + dancer.spring_n_per_m * half)
        force = self.dancer_force_n - dancer.spring_n_per_m * self.dancer_m
        return _Affine(
            (dancer.mass_kg * self.dancer_speed + half * force) / yields,
            half * self._strands / yields,
        )

    def _mean_tension(self, roll: _Affine, dancer: _Affine, seconds: float, line_m: float) -> float:
        if self.is_broken:
            return 0.0
        stretch, half = self.stretch_m, seconds / 2
        roll_share, line_share = self._shares(stretch)
        surface = self.radius_m * roll_share
        rate = self._strands * dancer.free + self._sense * (roll.free * surface - line_m / seconds * line_share)
        rate_per_n = self._strands * dancer.per_n + self._sense * roll.per_n * surface
        stiffness = self._stiffness_n / self.span_m
        gain = stiffness * (half + self._damping_s)
        tension = (stiffness * stretch + gain * rate) / (1 + gain * rate_per_n)
        is_taut = stretch + half * (rate - rate_per_n * tension) > 0
        return max(0.0, tension) if is_taut else 0.0

    def _move(self, seconds: float, mean: float, means: _Means, line_m: float) -> None:
        """Move to the end of the step at these mean speeds."""
        turned, before_m = mean * seconds, self.radius_m
        roll_share, line_share = self._shares(self.stretch_m)
        self.angle += turned
        self.speed = 2 * mean - self.speed if mean or self.speed else 0.0
        self._move_dancer(seconds, means.dancer)
        if self.is_broken:
            return
        self.mount(before_m + self._sense * self._settings.thickness_m * turned / tau)
        rolled_m = turned * (before_m + self.radius_m) / 2
        self.span_m -= self._sense * (rolled_m * roll_share - line_m * line_share)
        if self.span_m * MOST_DRAWN_OUT < self._way:
            self.span_m = self._way
            self.break_web()
        if self.radius_m <= self._settings.core_radius_m and self._sense < 0:
            self.mount(self._settings.core_radius_m)
            self.break_web()  # the end of the web has left the core

    def _move_dancer(self, seconds: float, mean: float) -> None:
        dancer = self._settings.dancer
        if dancer is None:
            return
        position_m, near_m = self.dancer_m + mean * seconds, 1e-12 * dancer.travel_m
        is_held = not near_m < position_m < dancer.travel_m - near_m
        self.dancer_m = min(max(position_m, 0.0), dancer.travel_m)
        self.dancer_speed = 0.0 if is_held else 2 * mean - self.dancer_speed
