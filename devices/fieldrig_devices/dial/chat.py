"""The conversation with a modem until it is connected, as passive code.

Source: ITU-T V.250 for the commands and the result codes in words, 5.7.1; the digit 0 for OK is understood as well.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from fieldrig.clock import MS, Alarm, S, VirtualClock

LONGEST_LINE: Final = 256
"""Bytes without an end of line that are kept."""
ANSWER_NS: Final = 3 * S
PAUSE_NS: Final = 300 * MS
"""Time between an answer and the next command, which many modems need."""
PROBES: Final = 3
"""How often a modem is asked whether it is there."""

DEFAULT_INIT: Final = ("AT&F E0 Q0 V1 X4 &C1 &D2",)


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a call failed, in a sentence, and what the user can do."""

    what: str
    remedy: str


NO_MODEM: Final = Failure(
    "The modem does not answer.", "Check its power and cable, and the bit rate; without a modem, leave out the number."
)
NO_CONNECTION: Final = Failure(
    "The modem did not connect in time.", "Allow more time with --timeout, or call the number by telephone to hear it."
)
# V.250, 6.3: what may come instead of CONNECT, and older forms of it.
FAILURES: Final = {
    "BUSY": Failure("The number is busy.", "Try again later."),
    "NO ANSWER": Failure("The number does not answer.", "Check that the modem at the controller is on (S0, Com1User)."),
    "NO CARRIER": Failure(
        "There is no carrier: no modem answered, or the modems found no common way to transmit.",
        "Check the number, that the modem at the controller answers, and the modulation (+MS) of both.",
    ),
    "NO DIALTONE": Failure("The modem hears no dial tone.", "Check its telephone line."),
    "DELAYED": Failure("The modem refuses to dial this number again so soon.", "Wait some minutes."),
    "BLACKLISTED": Failure("The modem refuses to dial this number.", "Switch the modem off and on."),
    "ERROR": Failure("The modem does not accept the number.", "Expected digits, and * # , W T P as its manual says."),
}
FAILURES["NO DIAL TONE"] = FAILURES["NO DIALTONE"]
FAILURES["NO DIAL-TONE"] = FAILURES["NO DIALTONE"]


class Chat:
    """Initialises a modem, dials, and waits for CONNECT."""

    def __init__(
        self,
        number: str,
        init: Sequence[str],
        dial_ns: int,
        transmit: Callable[[bytes], None],
        say: Callable[[str], None],
        on_connected: Callable[[bytes], None],
        on_failed: Callable[[Failure], None],
    ) -> None:
        """`dial_ns` is the longest time from dialling to CONNECT.

        `on_connected` is called with the bytes that have already arrived behind CONNECT.
        """
        self._orders = ["AT", *init, f"ATDT{number}"]
        self._dial_ns, self._transmit, self._say = dial_ns, transmit, say
        self._on_connected, self._on_failed = on_connected, on_failed
        self._clock = VirtualClock()
        self._timer = Alarm(self._clock)
        self._line = bytearray()
        self._place = -1
        self._tries = 0
        self.is_over = False

    def start(self, now_ns: int) -> None:
        self._clock.advance_to(now_ns)
        self._next()

    def next_ns(self) -> int | None:
        return None if self.is_over else self._clock.next_ns()

    def advance(self, now_ns: int) -> None:
        self._clock.advance_to(now_ns)

    def receive(self, now_ns: int, data: bytes) -> None:
        """Take bytes from the modem; what comes behind CONNECT goes to `on_connected`."""
        self._clock.advance_to(now_ns)
        for place, byte in enumerate(data):
            if byte not in b"\r\n":
                self._line.append(byte)
                del self._line[:-LONGEST_LINE]
                continue
            word = self._line.decode("ascii", "replace").strip().upper()
            self._line.clear()
            self._on_line(word)
            if self.is_over:
                if word.startswith("CONNECT"):
                    self._on_connected(data[place + 1 :].removeprefix(b"\n"))
                return

    def stop(self) -> None:
        """Give up; a modem that dials stops (V.250, 5.6.1: any character ends the attempt)."""
        self.is_over = True
        self._transmit(b"\r")

    # ---- one order after another

    @property
    def _is_dialling(self) -> bool:
        return self._place == len(self._orders) - 1

    def _next(self) -> None:
        self._place, self._tries = self._place + 1, 0
        if self._is_dialling:
            self._say(f"The modem dials {self._orders[-1].removeprefix('ATDT')}.")
        self._order()

    def _order(self) -> None:
        self._tries += 1
        self._transmit(self._orders[self._place].encode("ascii", "replace") + b"\r")
        self._wait(self._dial_ns if self._is_dialling else ANSWER_NS, self._on_silence)

    def _on_line(self, word: str) -> None:
        if not self._timer.is_set or not word:
            return
        if self._is_dialling:
            self._on_dialled(word)
        elif word in ("OK", "0"):
            if self._place == 0:
                self._say("The modem answers.")
            self._wait(PAUSE_NS, self._next)
        elif word == "ERROR" and self._place > 0:
            order = self._orders[self._place]
            self._fail(Failure(f"The modem refuses {order}.", "Name another initialisation with --init."))

    def _on_dialled(self, word: str) -> None:
        if word.startswith("CONNECT"):
            speed = word.removeprefix("CONNECT").strip()
            self._say(f"The modem is connected ({speed})." if speed else "The modem is connected.")
            self.is_over = True
        elif word in FAILURES:
            self._fail(FAILURES[word])

    def _on_silence(self) -> None:
        if self._is_dialling:
            self.stop()
            self._on_failed(NO_CONNECTION)
        elif self._place == 0 and self._tries < PROBES:
            self._order()
        else:
            self._fail(NO_MODEM)

    def _fail(self, failure: Failure) -> None:
        self.is_over = True
        self._on_failed(failure)

    def _wait(self, wait_ns: int, then: Callable[[], None]) -> None:
        self._timer.after(wait_ns, then)
