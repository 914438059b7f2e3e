"""Names that a user types, checked at once: a wrong one is answered with the nearest one that exists."""

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase

from fieldrig.errors import ControlError, RigError, UsageError
from fieldrig.wording import closest


def check_name(name: str, known: Sequence[str], wrong: str) -> None:
    """ControlError that begins with `wrong` and the name, with the nearest name, if it is none of those known."""
    if name not in known:
        raise ControlError(f"{wrong} {name!r}", closest(name, list(dict.fromkeys(known))))


def check_patterns(
    patterns: Iterable[str], known: Sequence[str], wrong: str, error: type[RigError] = ControlError
) -> None:
    """Raise `error` for the first pattern that fits none of the known names; a * matches any characters."""
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in known):
            raise error(f"{wrong} {pattern!r}", closest(pattern, list(dict.fromkeys(known))))


def check_in_file(patterns: Iterable[str] | None, known: Sequence[str], file: object, what: str) -> None:
    """UsageError for the first pattern that fits nothing in a file."""
    check_patterns(patterns or (), known, f"{file} has no {what}", UsageError)
