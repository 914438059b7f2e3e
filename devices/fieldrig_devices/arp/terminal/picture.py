"""The screen that the card has sent to the terminal, and the values on it that follow the card's variables."""

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
        """`send` is called with the first identifier of a PDO and its data; `follows` is from `terminal_value`."""
        self._variables, self._follows, self._send = variables, follows, send
        self._texts: dict[Place, tuple[Show, str | None]] = {}
        """Texts by place, with the message as it was then, if the card knows it."""
        self._sent: dict[Place, int] = {}
        """Values on the screen by place; the one that was sent last comes last."""

    def carry_out(self, job: Clear | Erase | Show, message: str | None) -> None:
        """Send an action.  `message` is the text stored under the job's message number, if the card knows it."""
        match job:
            case Clear():
                self._texts.clear()
                self._sent.clear()
                self._send(objects.SCREEN_ID, ScreenCommand(Act.CLEAR).encode())
            case Erase(place):
                self._forget(place)
                self._send(objects.SCREEN_ID, ScreenCommand(Act.ERASE, *place).encode())
            case Show():
                self._show(job, message)

    def redrawn(self) -> list[Job]:
        """Jobs that draw the screen on a terminal that shows something else."""
        return [Clear(), *(show for show, _ in self._texts.values())]

    def edited(self, place: Place, raw: int) -> int | None:
        """Number of the variable that the operator has changed at a place, or None if there is no editable variable."""
        shown = self._texts[place][0].shown if place in self._texts else None
        if shown is None or not shown.mode:
            return None
        self._sent[place] = raw
        return shown.variable

    def next_values(self) -> "list[tuple[Place, int]]":
        """Values that the terminal does not have yet; the one that was sent last comes last."""
        if not self._follows:
            return []
        values = ((place, self._value(self._texts[place][0]), sent) for place, sent in self._sent.items())
        return [(place, raw) for place, raw, sent in values if raw != sent]

    def send_value(self, place: Place, raw: int) -> None:
        self._sent.pop(place, None)
        self._sent[place] = raw
        self._send(objects.VALUE_ID, ValueAt(*place, raw).encode())

    def _forget(self, place: Place) -> None:
        self._texts.pop(place, None)
        self._sent.pop(place, None)

    def _show(self, job: Show, message: str | None) -> None:
        """Send a text, unless it is already on the screen; an edit in progress there is not disturbed."""
        place, shown = job.place, job.shown
        if self._present(place) != (shown, message):
            self._forget(place)
            act = Act.SHOW if shown.variable is None else _ACTS[shown.mode]
            self._send(objects.SCREEN_ID, ScreenCommand(act, *place, shown.height, shown.message).encode())
        self._texts[place] = (job, message)
        if shown.variable is not None and (place not in self._sent or not self._follows):
            self.send_value(place, self._value(job))

    def _present(self, place: Place) -> tuple[Shown, str | None] | None:
        present = self._texts.get(place)
        return None if present is None else (present[0].shown, present[1])

    def _value(self, show: Show) -> int:
        assert show.shown.variable is not None
        return self._variables[show.shown.variable] if self._follows or show.raw is None else show.raw
