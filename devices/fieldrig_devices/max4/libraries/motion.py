"""The state that blocks and functions share: the profiles by number, and the follower of each axis."""

from collections.abc import Callable
from math import isfinite
from typing import Final

from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.libraries.controller import MotionController
from fieldrig_devices.max4.libraries.follower import CamFollower
from fieldrig_devices.motion.curves.laws import LAWS
from fieldrig_devices.motion.curves.laws.law import Law
from fieldrig_devices.motion.curves.profile import Profile, shaped
from fieldrig_devices.motion.curves.spline import profile_of_file

MOST_PROFILES: Final = 1024
SUFFIX: Final = ".CAM"
"""The suffix of a file of support points, if the program does not give one."""
SMALLEST_FACTOR: Final = 1e-9
LARGEST: Final = 1e12
"""Beyond this the positions of an axis are not whole increments any more."""


def is_usable(*values: float) -> bool:
    return all(isfinite(value) and abs(value) <= LARGEST for value in values)


class Profiles:
    """The profiles that the program has loaded, by their numbers from 1."""

    def __init__(self, controller: MotionController) -> None:
        self._controller = controller
        self._profiles: list[Profile] = []
        self._laws: list[Law | None] = []

    def __getitem__(self, number: int) -> Profile:
        """KeyError if there is none."""
        if not 1 <= number <= len(self._profiles):
            raise KeyError(number)
        return self._profiles[number - 1]

    def load(self, name: str) -> int:
        """The number of a new profile: a law, or support points of a file.  0 if there is none of this name.

        Each call returns a profile of its own, because each has its own lambda (PD-187, PD-188).
        """
        law = LAWS.get(name.strip().casefold())
        if law is not None:
            return self.add(shaped(law), law)
        try:
            return self.add(profile_of_file(self._controller.read_file(file_of(name.strip()))))
        except ValueError:
            return 0

    def add(self, profile: Profile, law: Law | None = None) -> int:
        if len(self._profiles) >= MOST_PROFILES:
            return 0
        self._profiles.append(profile)
        self._laws.append(law)
        return len(self._profiles)

    def set_lambda(self, number: int, turning_point: float) -> bool:
        """Reshape a profile of a law, for the cams that begin from now on (PD-180).  False if that is not possible."""
        law = self._laws[number - 1] if 1 <= number <= len(self._laws) else None
        if law is None or not 0 <= turning_point <= 1:
            return False
        self._profiles[number - 1] = shaped(law, turning_point)
        return True

    def replace(self, number: int, profile: Profile) -> bool:
        """Give a number another curve.  False if there is none."""
        if not 1 <= number <= len(self._profiles):
            return False
        self._profiles[number - 1], self._laws[number - 1] = profile, None
        return True

    def clear(self) -> None:
        self._profiles.clear()
        self._laws.clear()


def file_of(name: str) -> str:
    """The name of the file on the flash disk: `\\\\BELT.CAM` for `belt`."""
    name = name if name.startswith("\\") else "\\" + name
    return name if "." in name else name + SUFFIX


class Motion:
    """The motion of one controller, for one boot."""

    def __init__(self, controller: MotionController) -> None:
        self.controller = controller
        self.profiles = Profiles(controller)
        self._followers: dict[int, CamFollower] = {}
        self._clearings: list[Callable[[], None]] = [self.profiles.clear]

    def follower(self, axis: Axis) -> CamFollower:
        if axis.log_adr not in self._followers:
            self._followers[axis.log_adr] = CamFollower(axis)
        return self._followers[axis.log_adr]

    def on_clear(self, action: Callable[[], None]) -> None:
        """Call `action` when the program is initialised."""
        self._clearings.append(action)

    def clear(self) -> None:
        """Forget what the program has loaded.  Axes finish the cams that they have taken."""
        for action in self._clearings:
            action()
