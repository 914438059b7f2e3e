"""Troubles of devices that may be the host's: each comes with words about how late the host was when it began.

A device that stops because its ring or its master was late reports a fault of its own, though nothing is wrong with it.
So its process looks at what its devices report (`Device.troubles`) every half second, and keeps beside each new trouble
how late the host was then, for `fieldrig get`, `fieldrig status` and the log.  A process may learn only some seconds
later that another process of the rig was late, such as that of a ring's station, so a trouble that has no words yet
still takes them for `LATER_NS`.
"""

import logging
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from fieldrig.device import Device, Value
from fieldrig.system.host_lateness import WINDOW_NS
from fieldrig.text.digits import show_value

log = logging.getLogger(__name__)

LATER_NS: Final = 2 * WINDOW_NS
"""Time after the begin of a trouble in which words about the host still belong to it."""


@dataclass
class _Trouble:
    value: Value
    begun_ns: int
    words: str = ""


class Troubles:
    """The troubles of one device."""

    def __init__(self, name: str, device: Device, host_words: Callable[[], str]) -> None:
        """`host_words` returns how late the host was in the last seconds; "" if it was not."""
        self._name, self._device, self._host_words = name, device, host_words
        self._present: dict[str, _Trouble] = {}

    def look(self, now_ns: int) -> None:
        """Note what has begun and what is over since the last look."""
        present = {key: value for key, value in self._device.troubles().items() if value}
        for key in self._present.keys() - present.keys():
            del self._present[key]
        for key, value in present.items():
            trouble = self._present.get(key)
            if trouble is None:
                trouble = self._present[key] = _Trouble(value, now_ns)
            elif trouble.value != value:  # words of an earlier trouble stay: this one may have followed from it
                trouble.value, trouble.begun_ns = value, now_ns
            else:
                if trouble.words or now_ns - trouble.begun_ns > LATER_NS:
                    continue
            self._note(key, trouble)

    def words(self) -> Mapping[str, str]:
        """Return the words about the host beside each trouble, by key; without those that have none."""
        return {key: trouble.words for key, trouble in self._present.items() if trouble.words}

    def _note(self, key: str, trouble: _Trouble) -> None:
        words = self._host_words()
        if words:
            trouble.words = f"at {time.strftime('%H:%M:%S')} {words}"
            log.warning("%s/%s is %s (%s)", self._name, key, _in_a_line(trouble.value), trouble.words)


def _in_a_line(value: Value) -> Any:
    return str(show_value(value, "")).replace("\n", "; ")
