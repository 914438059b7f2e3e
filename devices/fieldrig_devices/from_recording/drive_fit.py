"""The personality of a drive that fits a recording best, and the single differences that remain."""

from collections.abc import Mapping
from math import isinf
from typing import Any, Final, NamedTuple, get_args

from fieldrig_devices.cia402.single.personality import Name, PersonalitySettings, rows_of
from fieldrig_devices.from_recording.drive_signs import Delay, Signs
from fieldrig_devices.from_recording.objects import ObjectLogs

LEAST_MS: Final = 5.0
"""Times below this are as good as none: a bus, a control cycle and a master that polls add as much."""
RATIO: Final = 1.5
"""Factor within which two times are alike."""
FREE_BITS: Final = frozenset({"bit_14", "bit_15"})
"""Bits of the status word whose meaning no recording says."""
BY_THE_BOOK: Final = "by the book"


class Fit(NamedTuple):
    """The choice for a drive."""

    personality: str | None
    behaviour: dict[str, Any]
    """Keys that differ from the personality."""
    objects: list[str]
    """Keys of the objects to which the recording gives another power-on value than the personality."""
    why: list[str]
    """The reasons, in sentences without a period."""


def fit(signs: Signs, logs: ObjectLogs, missing: frozenset[int]) -> Fit:
    """Return the personality with most of the signs; without a clear winner, a drive by the book.

    `missing` are the objects that the drive has refused as unknown.
    """
    there = {index for (index, _), log in logs.by_key.items() if log.is_there}
    scores = {name: _score(_expected(name), signs, logs, missing, there) for name in (None, *get_args(Name))}
    best = max(scores, key=lambda name: (scores[name][0] - scores[name][1], name is None))
    expected = _expected(best)
    behaviour = {
        key: _plain(value)
        for key, value in signs.items()
        if key not in FREE_BITS and not _is_alike(key, expected, value)
    }
    if "voltage_bit" in behaviour:
        behaviour["voltage_bit"] = "enabled" if signs["voltage_bit"] else "ready"
    objects = [
        key
        for key, value in expected["objects"].items()
        if (number := _number(logs, key)) is not None and number != value
    ]
    if there & set(expected["missing"]):
        behaviour["missing"] = sorted(set(expected["missing"]) - there)
    return Fit(best, behaviour, objects, _why(best, scores, signs))


def _expected(name: str | None) -> dict[str, Any]:
    """Return the whole behaviour of a personality."""
    keys = PersonalitySettings.model_validate({} if name is None else rows_of(name)).model_dump(mode="json")
    keys["sdo_answer_most_ms"] = max(keys["sdo_answer_ms"], keys["sdo_answer_most_ms"])
    return keys


def _score(
    expected: Mapping[str, Any], signs: Signs, logs: ObjectLogs, missing: frozenset[int], there: set[int]
) -> tuple[int, int]:
    """Return how many signs agree, and how many contradict."""
    agreed = [_is_alike(key, expected, value) for key, value in signs.items()]
    agreed += [
        number == value for key, value in expected["objects"].items() if (number := _number(logs, key)) is not None
    ]
    lacked = set(expected["missing"])
    agreed += [True for index in lacked if index in missing] + [False for index in lacked if index in there]
    agreed += [False for index in missing if index >= 0x6000 and index not in lacked]
    return sum(agreed), len(agreed) - sum(agreed)


def _is_alike(key: str, behaviour: Mapping[str, Any], value: Any) -> bool:
    """True if a sign is what one expects of this behaviour."""
    expected = behaviour[key]
    match key:
        case "modes":
            return expected is None or {mode for mode in expected if mode > 0} == set(value)
        case "bit_14" | "bit_15":
            return bool(expected != "none")
        case "voltage_bit":
            return bool((expected == "enabled") == value)
        case "mode_display_ms" if behaviour["mode_display"] == "enabled":
            return True  # it follows once the drive is enabled, whenever that is
    if not isinstance(value, Delay):
        return bool(expected == value)
    return bool(value.least_ms / RATIO - LEAST_MS <= expected <= value.most_ms * RATIO + LEAST_MS)


def _number(logs: ObjectLogs, key: str) -> int | None:
    """Return the power-on value of an object as the recording has it, by a key such as `605A:00`."""
    log = logs.by_key.get((int(key[:4], 16), int(key[5:], 16)))
    return None if log is None or log.first is None else int.from_bytes(log.first, "little")


def _plain(value: Any) -> Any:
    """Return a sign as the rig file has it; a delay is its middle, or what it is at least."""
    if not isinstance(value, Delay):
        return value
    usual_ms = value.least_ms if isinf(value.most_ms) else (value.least_ms + value.most_ms) / 2
    return float(f"{usual_ms:.3g}")


def _why(best: str | None, scores: Mapping[str | None, tuple[int, int]], signs: Signs) -> list[str]:
    agreed, contradicted = scores[best]
    expected = _expected(best)
    fitting = [f"{key} {_shown(value)}" for key, value in signs.items() if _is_alike(key, expected, value)]
    words = f"personality {best or BY_THE_BOOK}: {agreed} of {agreed + contradicted} signs of the recording fit"
    others = sorted((score for name, score in scores.items() if name != best), key=lambda score: score[1] - score[0])
    words += f", and {others[0][0]} of {sum(others[0])} fit the next best one"
    return [words, *([f"they are {', '.join(fitting)}"] if fitting else [])]


def _shown(value: Any) -> str:
    if isinstance(value, Delay):
        low, high = f"{value.least_ms:.3g}", f"{value.most_ms:.3g}"
        if isinf(value.most_ms):
            return f"at least {low}"
        return low if low == high else f"{low} to {high}"
    return str(value).lower() if isinstance(value, bool) else str(value)
