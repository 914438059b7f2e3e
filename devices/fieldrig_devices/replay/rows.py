"""Messages that are missing, more or late in a row: they are one difference."""

from collections.abc import Callable
from dataclasses import dataclass

from fieldrig_devices.replay.replay_result import What
from fieldrig_devices.replay.streams import Stream
from fieldrig_devices.replay.words import late_words, time_words


@dataclass(slots=True)
class Row:
    """Messages of one stream with the same sort of difference."""

    what: What
    time_ns: int
    """The instant of the first of them."""
    content: str
    """The values of the first of them, in words."""
    late_ns: int
    most_late_ns: int
    count: int = 1

    def words(self, who: str, subject: str) -> str:
        """Return the difference in one sentence; `who` has sent the messages, or should have."""
        match self.what:
            case What.MISSING:
                words = f"{who} did not send {subject} {self.content}"
            case What.MORE:
                words = f"{who} sent {subject} {self.content}, which the log does not have"
            case _:
                words = f"{who} sent {subject} {self.content}, {late_words(self.late_ns)}"
        if self.count > 1:
            most = f", by at most {time_words(abs(self.most_late_ns))}" if self.late_ns else ""
            words += f" ({self.count} of them in a row{most})"
        return words


class Rows:
    """The rows that go on at present, by stream."""

    def __init__(self, report: Callable[[Stream, Row], None]) -> None:
        self._report = report
        self._rows: dict[Stream, Row] = {}

    def take(self, stream: Stream, what: What, time_ns: int, content: str, late_ns: int = 0) -> None:
        """Take a message that is missing, more or late."""
        row = self._rows.get(stream)
        if row is not None and row.what is what and (row.late_ns > 0) == (late_ns > 0):
            row.count += 1
            row.most_late_ns = max(row.most_late_ns, late_ns, key=abs)
            return
        self.end(stream)
        self._rows[stream] = Row(what, time_ns, content, late_ns, late_ns)

    def end(self, stream: Stream) -> None:
        """Take into account that a message of the stream is as it should be."""
        row = self._rows.pop(stream, None)
        if row is not None:
            self._report(stream, row)

    def finish(self) -> None:
        """Report all rows that go on."""
        for stream in list(self._rows):
            self.end(stream)
