"""`fieldrig watch` without a bus, on a busy rig."""

from collections.abc import Iterator

from fieldrig.cli.thinning import FEWEST, LINES_OF_A_WINDOW, Line, thinned


class Watched:
    """Lines that come at the instants of a clock of their own."""

    def __init__(self, *lines: tuple[float, str]) -> None:
        self._lines, self._now_s = lines, 0.0

    def now_s(self) -> float:
        return self._now_s

    def __iter__(self) -> Iterator[Line | None]:
        for at_s, bus in self._lines:
            self._now_s = at_s
            yield (f"{bus} at {at_s}", {"bus": bus, "sender": "io"}) if bus else ("event", {"event": {}})
        self._now_s += 10
        yield None

    def shown(self, buses: int) -> list[str]:
        return [line[0] for line in thinned(iter(self), buses, self.now_s) if line is not None]


def test_a_quiet_rig_is_shown_in_full() -> None:
    assert Watched((0.1, "can0"), (0.2, "wires"), (0.3, "can0")).shown(2) == [
        "can0 at 0.1",
        "wires at 0.2",
        "can0 at 0.3",
    ]


def test_a_busy_bus_is_thinned_out_and_said_so() -> None:
    shown = Watched(*((0.001 * number, "can0") for number in range(500))).shown(1)
    assert len(shown) == LINES_OF_A_WINDOW + 1
    assert shown[-1] == (
        f"-- {500 - LINES_OF_A_WINDOW} more messages in this second (can0 {500 - LINES_OF_A_WINDOW});"
        " `fieldrig watch can0` shows all of one"
    )


def test_a_busy_bus_hides_neither_another_one_nor_events() -> None:
    flood = [(0.001 * number, "can0") for number in range(500)]
    shown = Watched(*flood, (0.6, "wires"), (0.7, ""), (0.8, "wires")).shown(40)
    assert [line for line in shown if "can0 at" not in line][:3] == ["wires at 0.6", "event", "wires at 0.8"]
    assert sum("can0 at" in line for line in shown) == FEWEST


def test_each_second_begins_anew() -> None:
    shown = Watched(*((0.01 * number, "can0") for number in range(250))).shown(1)
    assert sum("more messages" in line for line in shown) == 3
    assert sum("can0 at" in line for line in shown) == 3 * LINES_OF_A_WINDOW
