"""The editor by which the operator changes a value on the screen.

Source: manual 5.12 (TERM, mode E and P) says that values can be changed, and names the keys; the rest is ours
(docs/devices/arp/arp-terminal.md):

    idle            arrows                          the cursor moves to the next or previous editable field
                    digit, POINT, MINUS or CR       typing begins with that key; mode P first requires the password
    typing          digits, POINT, MINUS, DEL       the text changes as far as the pattern permits
                    CR                              the value is reported, or the password is checked
                    ESC                             the value is kept
"""

from collections.abc import Callable
from enum import Enum, auto
from typing import Final

from fieldrig_devices.arp.terminal.screen import Place, Screen, Text

CHARACTERS: Final = frozenset("0123456789") | {"POINT", "MINUS"}
FORWARD: Final = frozenset({"DOWN", "RIGHT"})
BACK: Final = frozenset({"UP", "LEFT"})
LONGEST_PASSWORD: Final = 8


class Phase(Enum):
    IDLE = auto()
    PASSWORD = auto()
    TYPING = auto()


class Editor:
    def __init__(self, screen: Screen, password: str, on_value: Callable[[Place, int], None]) -> None:
        """`on_value` is called with the place and the raw value that was entered there."""
        self._screen, self._password, self._on_value = screen, password, on_value
        self._phase = Phase.IDLE
        self._place: Place | None = None
        self._text: Text | None = None
        self._secret = ""

    @property
    def cursor(self) -> Place | None:
        """Cell of the cursor, or None if there is no editable field."""
        return None if self._place is None else self._screen.field_cell(self._place)

    def follow(self) -> None:
        """Follow a change of the screen: input for a text that has disappeared is discarded."""
        if self._place is None or self._screen.texts.get(self._place) is not self._text:
            self._phase = Phase.IDLE
            self._go_to(self._place)

    def press(self, key: str) -> None:
        if self._place is None or self._text is None:
            return
        if self._phase is not Phase.IDLE:
            self._type(key, self._text)
        elif key in FORWARD | BACK:
            self._move(1 if key in FORWARD else -1)
        elif key in CHARACTERS or key == "CR":
            self._begin(Phase.PASSWORD if self._text.edit == "P" else Phase.TYPING, self._text)
            if key != "CR":
                self._type(key, self._text)

    def _go_to(self, place: Place | None) -> None:
        """Move to `place` if it is editable, or else to the first editable place."""
        places = self._screen.editable()
        self._place = place if place in places else next(iter(places), None)
        self._text = None if self._place is None else self._screen.texts[self._place]

    def _move(self, step: int) -> None:
        places = self._screen.editable()
        assert self._place is not None
        self._go_to(places[(places.index(self._place) + step) % len(places)])

    def _begin(self, phase: Phase, text: Text) -> None:
        self._phase, self._secret, text.typed = phase, "", ""

    def _end(self, text: Text) -> None:
        self._phase, text.typed = Phase.IDLE, None

    def _type(self, key: str, text: Text) -> None:
        if key == "ESC":
            self._end(text)
        elif self._phase is Phase.PASSWORD:
            self._type_password(key, text)
        elif key == "CR":
            self._enter(text)
        elif key in CHARACTERS or key == "DEL":
            field = text.field
            assert field is not None
            text.typed = field.typed(text.typed or "", key)

    def _type_password(self, key: str, text: Text) -> None:
        if key == "CR":
            self._end(text)
            if self._secret == self._password:
                self._begin(Phase.TYPING, text)
            return
        if key == "DEL":
            self._secret = self._secret[:-1]
        elif key.isdigit() and len(self._secret) < LONGEST_PASSWORD:
            self._secret += key
        text.typed = "*" * len(self._secret)

    def _enter(self, text: Text) -> None:
        field = text.field
        assert field is not None
        assert self._place is not None
        raw = field.parse(text.typed or "")
        self._end(text)
        if raw is not None:  # an empty input keeps the value
            text.value = raw
            self._on_value(self._place, raw)
