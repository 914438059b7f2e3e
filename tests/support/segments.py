"""A stream as a connection delivers it: in segments of any length."""

from collections.abc import Iterator, Sequence
from itertools import pairwise


def segments(stream: bytes, cuts: Sequence[int]) -> Iterator[bytes]:
    """Yield the whole stream in order, cut at `cuts`; a place beyond its end counts from its start again."""
    edges = sorted({0, len(stream), *(cut % (len(stream) + 1) for cut in cuts)})
    for start, stop in pairwise(edges):
        yield stream[start:stop]
