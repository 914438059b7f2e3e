"""Coverage in LCOV's form.

Source: the man page geninfo(1), section TRACEFILE FORMAT.  A number of executions is 0 or 1, as marks do not count.
"""

from collections.abc import Iterator

from fieldrig.coverage.places import Kind
from fieldrig.coverage.summary import Coverage, Part, pous


def lcov(coverage: Coverage) -> bytes:
    """Return the tracefile."""
    lines = [line for file in coverage.files() for line in _file(file)]
    return "".join(f"{line}\n" for line in lines).encode()


def _file(file: Part) -> Iterator[str]:
    yield "TN:"
    yield f"SF:{file.name}"
    yield from _functions(pous(file))
    lines = file.lines()
    yield from _branches(file)
    yield from _decisions(file)
    yield from (f"DA:{line},{int(has_run)}" for line, has_run in lines.items())
    yield f"LF:{len(lines)}"
    yield f"LH:{sum(lines.values())}"
    yield "end_of_record"


def _functions(parts: list[Part]) -> Iterator[str]:
    """Yield the POUs, each at its first line that can run."""
    names = {pou.name: (min(place.line for place, _ in pou.places), pou.count().run > 0) for pou in parts}
    yield from (f"FN:{line},{name}" for name, (line, _) in names.items())
    yield from (f"FNDA:{int(has_run)},{name}" for name, (_, has_run) in names.items())
    yield f"FNF:{len(names)}"
    yield f"FNH:{sum(has_run for _, has_run in names.values())}"


def _branches(file: Part) -> Iterator[str]:
    """Yield the branches; those of a choice that was never reached have `-`."""
    choices = file.branches()
    for of, branches in choices.items():
        columns = list(dict.fromkeys(place.column for place, _ in branches))
        for number, (place, has_run) in enumerate(branches):
            taken = str(int(has_run)) if file.has_reached(place) else "-"
            yield f"BRDA:{of},{columns.index(place.column)},{number},{taken}"
    every = [has_run for branches in choices.values() for _, has_run in branches]
    yield f"BRF:{len(every)}"
    yield f"BRH:{sum(every)}"


def _decisions(file: Part) -> Iterator[str]:
    """Yield MC/DC as LCOV has it from 2.2 on: for each condition, whether it has decided as true and as false."""
    names: dict[tuple[int, int], dict[str, int]] = {}
    decisions: dict[tuple[int, int], dict[tuple[str, str], bool]] = {}
    for place, has_run in file.places:
        name, _, value = place.what.rpartition(" ")
        if place.kind is Kind.CONDITION:  # they come from left to right
            known = names.setdefault((place.line, place.column), {})
            known.setdefault(name, len(known))
        elif place.kind is Kind.DECIDES:
            seen = decisions.setdefault((place.line, place.column), {})
            seen[name, value] = seen.get((name, value), False) or has_run
    for at, seen in decisions.items():
        for (name, value), has_run in seen.items():
            yield f"MCDC:{at[0]},{len(names[at])},{value[0].lower()},{int(has_run)},{names[at][name]},{name}"
    if decisions:
        yield f"MCF:{sum(map(len, decisions.values()))}"
        yield f"MCH:{sum(sum(seen.values()) for seen in decisions.values())}"
