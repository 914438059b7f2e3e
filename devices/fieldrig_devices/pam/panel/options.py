"""Facts of the front panel that the manual leaves out, and passages about it that can be read in two ways."""

from typing import Literal

from pydantic import Field

from fieldrig.clock import MS
from fieldrig.settings import Settings

Several = Literal["latest", "first", "only_latest"]


class PanelOptions(Settings):
    """Settings of the display, the error list and the fatal error panel."""

    scroll_ms: int = Field(default=300, ge=1, description="time after which the scrolling name has moved by a digit")
    message_ms: int = Field(default=2_000, ge=1, description="time for which the display shows a message")
    monitor_ms: int = Field(default=500, ge=1, description="period at which a monitored value is sampled again")
    data_ms: int = Field(
        default=0,
        ge=0,
        description="time for which the display shows the code and then each data field in turn; 0: the code only",
    )
    several: Several = Field(
        default="latest",
        description="which of several errors or warnings is shown: the latest, then the earlier ones (latest), "
        "the first (first), or the latest and then the name (only_latest)",
    )
    scrolls: Literal["version", "date"] = Field(
        default="version", description="whether the version or the date of the start follows the scrolling name"
    )
    error_list: int = Field(default=100, ge=1, le=10_000, description="entries of the error list")
    date_begins: Literal["high", "low"] = Field(
        default="high",
        description="whether the year and the hour in the fatal error panel are the highest or the lowest bits",
    )

    @property
    def scroll_ns(self) -> int:
        return self.scroll_ms * MS

    @property
    def message_ns(self) -> int:
        return self.message_ms * MS

    @property
    def monitor_ns(self) -> int:
        return self.monitor_ms * MS

    @property
    def data_ns(self) -> int:
        return self.data_ms * MS
