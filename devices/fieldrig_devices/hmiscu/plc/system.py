"""The system functions that the manual shows in its examples: IsFirstMastCycle and SetRTCDrift (manual 2078 to 2135).

The manual gives their names and parameters only.  The enumerators of RTCDRIFT_ERROR are ours.
"""

from collections.abc import Iterator
from typing import Final

from fieldrig.device import Point
from fieldrig_devices.iec.host import Library, NativeFunction, Results

MOST_DRIFT: Final = 29
"""Largest correction of the clock in seconds a week, in either direction."""
OK, BAD_DRIFT, BAD_DAY, BAD_HOUR, BAD_MINUTE = range(5)
_TEXT: Final = """
TYPE
  DAY_OF_WEEK : (SUNDAY, MONDAY, TUESDAY, WEDNESDAY, THURSDAY, FRIDAY, SATURDAY);
  HOUR : USINT;
  MINUTE : USINT;
  RTCDRIFT_ERROR : (RTC_OK, RTC_BAD_DRIFT, RTC_BAD_DAY, RTC_BAD_HOUR, RTC_BAD_MINUTE);
  RTCSETDRIFT_ERROR : RTCDRIFT_ERROR;
END_TYPE

FUNCTION IsFirstMastCycle : BOOL
{native}
END_FUNCTION

FUNCTION SetRTCDrift : RTCDRIFT_ERROR
VAR_INPUT
  RtcDrift : SINT; (* -29 to 29 seconds a week *)
  Day : DAY_OF_WEEK; (* when the clock is corrected *)
  Hour : HOUR;
  Minute : MINUTE;
END_VAR
{native}
END_FUNCTION
"""


class SystemFunctions:
    """The state behind the functions."""

    def __init__(self) -> None:
        self._is_next_first = True
        self._is_first = False
        self._drift_s = 0

    def library(self) -> Library:
        functions = {"isfirstmastcycle": NativeFunction(self._first), "setrtcdrift": NativeFunction(self._set_drift)}
        return Library("PLCSystem", _TEXT, functions, {})

    def restart(self) -> None:
        """The controller goes to RUN: its next cycle is the first one."""
        self._is_next_first = True

    def begin_cycle(self) -> None:
        self._is_first, self._is_next_first = self._is_next_first, False

    def _first(self) -> Results:
        return (self._is_first,)

    def _set_drift(self, drift_s: int, day: int, hour: int, minute: int) -> Results:
        checks = ((abs(drift_s) <= MOST_DRIFT, BAD_DRIFT), (0 <= day <= 6, BAD_DAY), (hour <= 23, BAD_HOUR))
        for is_right, error in (*checks, (minute <= 59, BAD_MINUTE)):
            if not is_right:
                return (error,)
        self._drift_s = drift_s
        return (OK,)

    def points(self) -> Iterator[tuple[str, Point]]:
        about = "correction of the clock, in seconds a week"
        yield "rtc.drift", Point(lambda: self._drift_s, about=about)
