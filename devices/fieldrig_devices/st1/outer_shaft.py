"""The shaft of a motor that a plant models: the ST1 closes its loops over wires, a torque out and an encoder in.

Every millisecond under power the loop asks for the torque of the set acceleration, plus what the errors of speed and
position and the sum of the position's error ask for, up to the limit of the torque.  Its gains follow from the inertia
and one bandwidth.  When the shaft rests in its set position, the loop waits until something changes.
"""

from collections.abc import Callable
from math import floor, tau
from typing import Final

from fieldrig.clock import NEVER_NS, S
from fieldrig_bus.wires import Signal
from fieldrig_devices.st1.set_position import SetPosition
from fieldrig_devices.st1.settings import MotorSettings, PlantSettings, St1Settings
from fieldrig_devices.st1.shaft import LOOP_NS, TURN, Shaft
from fieldrig_devices.st1.torque import Torque

LOOP_S: Final = LOOP_NS / S
FULL_SCALE_V: Final = 10.0
_REST: Final = 1e-3  # V; a smaller change of the reference is none


class OuterShaft:
    __slots__ = (
        "_counts", "_encoder", "_gain", "_is_limited", "_is_powered", "_motor", "_offset", "_put", "_set", "_sum",
        "_torque", "_turn", "_volts", "acceleration", "friction", "is_blocked", "next_ns",
    )  # fmt: skip

    def __init__(
        self,
        set_position: SetPosition,
        torque: Torque,
        motor: MotorSettings,
        plant: PlantSettings,
        put: Callable[[float], None],
    ) -> None:
        """`put` is called with a new reference in volts: 10 V are the largest torque."""
        self._set, self._torque, self._motor, self._put = set_position, torque, motor, put
        self._counts = plant.counts_per_turn
        self._turn = TURN / plant.counts_per_turn
        self._gain = tau * plant.bandwidth_hz
        self._encoder = Signal("", 0.0)
        self._offset = 0
        """RU from the encoder to the motor."""
        self._volts = self._sum = 0.0
        self._is_powered = self._is_limited = False
        self.acceleration, self.friction = torque.acceleration, torque.coasting
        self.is_blocked = False
        self.next_ns = NEVER_NS

    # ---- where it is

    @property
    def is_following(self) -> bool:
        return self._is_powered

    def position_at(self, now_ns: int) -> int:
        return floor(float(self._encoder.at(now_ns)) * self._turn) + self._offset

    def speed_at(self, now_ns: int) -> float:
        return self._encoder.speed_at(now_ns) * self._turn

    def acceleration_at(self, now_ns: int) -> float:
        return 0.0

    def effort_at(self, now_ns: int) -> float:
        """Return the torque that the loop asks for, as `Shaft` does."""
        return self._torque.rate(self._volts / FULL_SCALE_V * self._motor.largest_torque_nm)

    def lag_at(self, now_ns: int) -> int:
        return self._set.motor_at(now_ns) - self.position_at(now_ns) if self._is_powered else 0

    def is_limited_at(self, now_ns: int) -> bool:
        return self._is_limited

    # ---- events

    def place(self, now_ns: int, position: int) -> None:
        self._offset += position - self.position_at(now_ns)

    def measure(self, encoder: Signal) -> None:
        """Take the encoder: a motion in counts."""
        self._encoder = encoder

    def power(self, now_ns: int, is_on: bool) -> None:
        self._is_powered, self._is_limited, self._sum = is_on, False, 0.0
        self.next_ns = now_ns if is_on else NEVER_NS
        if not is_on:
            self._give(0.0)

    def block(self, now_ns: int, is_on: bool) -> None:
        """Do nothing: the plant says whether its shaft is blocked."""
        self.is_blocked = is_on

    def leave(self, now_ns: int) -> None:
        """Do nothing: the shaft is where its encoder is."""

    def keeps_up(self, before: float, speed: float, interval_ns: int) -> bool:
        """True if the loop is working."""
        return self.next_ns < NEVER_NS

    def look(self, now_ns: int, speed_before: float | None = None) -> None:
        """Let the loop work if it is due, or has rested."""
        if self._is_powered and now_ns >= self.next_ns:
            self._control(now_ns)
        elif self._is_powered:
            self.next_ns = min(self.next_ns, now_ns + LOOP_NS)

    def _control(self, now_ns: int) -> None:
        error, gain = self.lag_at(now_ns) / TURN, self._gain
        speed_error = (self._set.speed_at(now_ns) - self.speed_at(now_ns)) / TURN
        total = self._sum + error * LOOP_S
        rate = self._set.acceleration_at(now_ns) / TURN
        rate += 3 * gain * speed_error + 3 * gain**2 * error + gain**3 * total
        torque_nm = rate * tau * self._motor.inertia_kg_m2
        most_nm = self._torque.limit * self._motor.largest_torque_nm
        self._is_limited = abs(torque_nm) > most_nm
        if not self._is_limited:
            self._sum = total
        before = self._volts
        self._give(min(max(torque_nm, -most_nm), most_nm) / self._motor.largest_torque_nm * FULL_SCALE_V)
        is_at_rest = not self._set.is_moving and not self.speed_at(now_ns) and abs(error) * self._counts < 1
        is_settled = is_at_rest and abs(self._volts - before) < _REST
        self.next_ns = NEVER_NS if is_settled else now_ns + LOOP_NS

    def _give(self, volts: float) -> None:
        if volts != self._volts:
            self._volts = volts
            self._put(volts)


def shaft_of(
    settings: St1Settings, set_position: SetPosition, torque: Torque, put: Callable[[float], None]
) -> Shaft | OuterShaft:
    """Return the shaft of the ST1's own motor, or that of a motor on wires."""
    if settings.plant is not None:
        return OuterShaft(set_position, torque, settings.motor, settings.plant, put)
    return Shaft(set_position, settings.parameters.ckv * TURN, torque.acceleration, torque.coasting)
