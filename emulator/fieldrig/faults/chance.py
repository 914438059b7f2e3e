"""Random numbers that come from other random numbers, so that one seed decides all of a rig."""

from random import Random
from weakref import WeakKeyDictionary

_children: "WeakKeyDictionary[Random, list[Random]]" = WeakKeyDictionary()


def derived(source: Random) -> Random:
    """Return random numbers of their own, from the next number of `source`."""
    child = Random(source.getrandbits(64))
    _children.setdefault(source, []).append(child)
    return child


def reseed(source: Random, seed: str | int) -> None:
    """Begin again from another seed, with everything that was derived from `source`."""
    source.seed(seed)
    for child in _children.get(source, ()):
        reseed(child, source.getrandbits(64))
