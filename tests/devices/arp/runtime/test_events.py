"""ON1 to ON6: interrupt routines by level, edge and position (manual 5.5)."""

import pytest
from arp_card import ArpBench

ENDLESS = "LOOP:\nV9 += 1\nGOTO LOOP"


def armed(event: str, routine: str = "V1 += 1") -> ArpBench:
    """A program with an endless loop and one event whose routine counts in V1; F1 enables it."""
    bench = ArpBench(f"BEG M\n{event}\n{ENDLESS}\nEND\nBEGA IRQ\n{routine}\nENDA")
    bench.card.F[1] = 1
    return bench


def served(bench: ArpBench) -> int:
    """Number of runs of the routine since the last call."""
    bench.run()
    count, bench.card.V[1] = bench.card.V[1] // 1000, 0
    return count


@pytest.mark.manual("ARP-087", "ARP-120")
@pytest.mark.parametrize(("bit", "table"), [("F5", "F"), ("I101", "I")])
def test_edges_are_served_once_each(bit: str, table: str) -> None:
    for edge, expected in (("/", [0, 1, 0, 0, 1]), ("\\", [0, 0, 0, 1, 0])):
        bench = armed(f"ON3 F1 & {edge}{bit} IRQ")
        values = getattr(bench.card, table)
        counts = []
        for level in (0, 1, 1, 0, 1):
            values[int(bit[1:])] = level
            counts.append(served(bench))
        assert counts == expected


@pytest.mark.manual("ARP-087")
@pytest.mark.parametrize(("condition", "level"), [("F5", 1), ("!F5", 0), ("I101", 1), ("!I101", 0)])
def test_levels_are_served_while_they_last(condition: str, level: int) -> None:
    bench = armed(f"ON1 F1 & {condition} IRQ", "V1 += 1\nRES F1")
    bench.card.F[5] = bench.card.I[101] = 1 - level
    assert served(bench) == 0
    bench.card.F[5] = bench.card.I[101] = level
    assert served(bench) == 1
    assert served(bench) == 0  # the routine has cleared its own enabling flag
    bench.card.F[1] = 1
    assert served(bench) == 1


@pytest.mark.manual("ARP-087")
@pytest.mark.parametrize(
    ("relation", "at", "expected"), [(">", 5_000, 0), (">", 5_001, 1), ("<", 5_000, 0), ("<", 4_999, 1)]
)
def test_positions_are_compared_with_a_variable(relation: str, at: int, expected: int) -> None:
    bench = armed(f"ON6 F1 & (2 {relation} V7), IRQ", "V1 += 1\nRES F1")
    bench.card.V[7], bench.card.positions[2] = 5_000, at
    assert served(bench) == 0  # armed in this slice
    assert served(bench) == expected


@pytest.mark.manual("ARP-088")
def test_the_variable_is_read_at_the_time_of_the_test() -> None:
    bench = armed("ON1 F1 & 1 > V7 IRQ", "V1 += 1\nRES F1")
    bench.card.V[7], bench.card.positions[1] = 5_000, 4_000
    assert served(bench) == 0
    bench.card.V[7] = 3_999
    assert served(bench) == 1


@pytest.mark.manual("ARP-089")
def test_a_level_that_stays_true_starves_the_main_program() -> None:
    bench = armed("ON1 F1 & F5 IRQ")
    bench.run(5)
    bench.card.F[5] = 1
    bench.run()
    before = bench.card.V[9]
    assert served(bench.run(20)) > 100
    assert bench.card.V[9] == before
    bench.card.F[5] = 0
    assert bench.run().card.V[9] > before


@pytest.mark.manual("ARP-090")
def test_a_bare_on_disarms_and_a_new_on_replaces() -> None:
    source = """\
BEG M
ON1 F1 & /F5 IRQ
LOOP:
IF F10 = HI, ON1
IF F11 = HI, ON1 F1 & /F6 IRQ
GOTO LOOP
END
BEGA IRQ
V1 += 1
ENDA"""
    bench = ArpBench(source)
    bench.card.F[1] = 1

    def pulse(flag: int) -> int:
        bench.card.F[flag] = 1
        count = served(bench)
        bench.card.F[flag] = 0
        bench.run()
        return count

    bench.run()
    assert (pulse(5), pulse(6)) == (1, 0)
    pulse(11)
    assert (pulse(5), pulse(6)) == (0, 1)
    pulse(10)
    assert (pulse(5), pulse(6)) == (0, 0)


def test_an_edge_while_disabled_is_not_remembered() -> None:
    bench = armed("ON1 F1 & /F5 IRQ")
    bench.card.F[1] = 0
    bench.run()
    bench.card.F[5] = 1
    assert served(bench) == 0
    bench.card.F[1] = 1
    assert served(bench) == 0


def test_the_lowest_number_goes_first_and_routines_do_not_nest() -> None:
    bench = ArpBench(f"""\
BEG M
ON5 F1 & /F5 FIVE
ON2 F1 & /F5 TWO
{ENDLESS}
END
BEGA FIVE
V1 == V1 * 10 + 5
ENDA
BEGA TWO
WAIT 0.005
V1 == V1 * 10 + 2
ENDA""")
    bench.card.F[1] = 1
    bench.run()
    bench.card.F[5] = 1
    bench.run(5)
    assert bench.card.V[1] == 0
    bench.run(2)
    assert bench.card.V[1] == 25_000


@pytest.mark.parametrize("main", ["WAIT 10", "PAC 1, 5"])
def test_events_are_served_while_the_main_program_waits(main: str) -> None:
    bench = ArpBench(f"BEG M\nON1 F1 & /I101 IRQ\n{main}\nEND\nBEGA IRQ\nV1 += 1\nENDA")
    bench.card.F[1] = bench.card.F[263] = 1
    bench.run(3)
    bench.card.I[101] = 1
    assert served(bench) == 1
    assert bench.card.asked == []


def test_an_interrupt_routine_may_call_subprograms() -> None:
    bench = ArpBench(
        f"BEG M\nON1 F1 & /F5 IRQ\n{ENDLESS}\nEND\nBEGA IRQ\nCALL SUB\nV1 += 1\nENDA\nBEG SUB\nV1 += 10\nEND"
    )
    bench.card.F[1] = 1
    bench.run()
    bench.card.F[5] = 1
    assert served(bench) == 11


def test_a_symbol_may_stand_for_the_axis_and_the_routine_follows_without_comma() -> None:
    bench = ArpBench("MASTER EQU 2\nBEG M\nON1 F1 & (MASTER > V7) IRQ\nWAIT 1\nEND\nBEGA IRQ\nV1 += 1\nRES F1\nENDA")
    bench.card.F[1], bench.card.positions[2] = 1, 1
    assert served(bench.run()) == 1


@pytest.mark.parametrize(
    "event", ["ON1 F[V3] & F5 IRQ", "ON1 F1 & F[V3] IRQ", "ON1 F1 & I[V3] IRQ", "ON1 F1 & 1 > V[V3] IRQ"]
)
def test_an_index_out_of_range_arms_nothing(event: str) -> None:
    bench = armed(event)
    bench.card.F[5] = bench.card.I[101] = 1
    assert served(bench) == 0
    assert bench.card.warnings == [203]
