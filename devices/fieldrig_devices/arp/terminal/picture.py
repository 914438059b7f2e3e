"""What the card has told the terminal to show, and the values there that follow its variables."""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.arp.runtime.card import Shown
from fieldrig_devices.arp.terminal import objects
from fieldrig_devices.arp.terminal.jobs import Clear, Erase, Job, Show
from fieldrig_devices.arp.terminal.objects import Act, ScreenCommand, ValueAt
from fieldrig_devices.arp.terminal.screen import Place

_ACTS: Final = {"": Act.SHOW_VALUE, "E": Act.EDIT, "P": Act.EDIT_WITH_PASSWORD}


class Picture:
    def __init__(self, variables: list[int], follows: bool, send: Callable[[int, bytes], None]) -> None:
        """`send` gets the first identifier of a PDO and its data; `follows` is the reading `terminal_value`."""
        self._variables, self._follows, self._send = variables, follows, send
        self._texts: dict[Place, tuple[Show, str | None]] = {}
        """With the message as it was then, if the card knows it."""
        self._told: dict[Place, int] = {}
        """The values that stand there; who was told last comes last."""

    def carry_out(self, job: Clear | Erase | Show, message: str | None) -> None:
        """`message` is what is stored under the number that it shows, if the card knows it."""
        match job:
            case Clear():
                self._texts.clear()
                self._told.clear()
                self._send(objects.SCREEN_ID, ScreenCommand(Act.CLEAR).encode())
            case Erase(place):
                self._forget(place)
                self._send(objects.SCREEN_ID, ScreenCommand(Act.ERASE, *place).encode())
            case Show():
                self._show(job, message)

    def redrawn(self) -> list[Job]:
        """What brings it to a terminal that shows something else."""
        return [Clear(), *(show for show, _ in self._texts.values())]

    def edited(self, place: Place, raw: int) -> int | None:
        """The number of the variable that the operator has changed there; None if he can't have."""
        shown = self._texts[place][0].shown if place in self._texts else None
        if shown is None or not shown.mode:
            return None
        self._told[place] = raw
        return shown.variable

    def next_values(self) -> "list[tuple[Place, int]]":
        """Those that the terminal hasn't got yet; who was told last comes last."""
        if not self._follows:
            return []
        values = ((place, self._value(self._texts[place][0]), told) for place, told in self._told.items())
        return [(place, raw) for place, raw, told in values if raw != told]

    def tell_value(self, place: Place, raw: int) -> None:
        self._told.pop(place, None)
        self._told[place] = raw
        self._send(objects.VALUE_ID, ValueAt(*place, raw).encode())

    def _forget(self, place: Place) -> None:
        self._texts.pop(place, None)
        self._told.pop(place, None)

    def _show(self, job: Show, message: str | None) -> None:
        """What stands there already is not told again, nor what is typed into it disturbed."""
        place, shown = job.place, job.shown
        if self._stands(place) != (shown, message):
            self._forget(place)
            act = Act.SHOW if shown.variable is None else _ACTS[shown.mode]
            self._send(objects.SCREEN_ID, ScreenCommand(act, *place, shown.height, shown.message).encode())
        self._texts[place] = (job, message)
        if shown.variable is not None and (place not in self._told or not self._follows):
            self.tell_value(place, self._value(job))

    def _stands(self, place: Place) -> tuple[Shown, str | None] | None:
        present = self._texts.get(place)
        return None if present is None else (present[0].shown, present[1])

    def _value(self, show: Show) -> int:
        assert show.shown.variable is not None
        return self._variables[show.shown.variable] if self._follows or show.raw is None else show.raw
