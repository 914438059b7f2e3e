"""The channels of one member of a relay, by opener and number."""

from fieldrig_bus.ip.channel import Channel
from fieldrig_bus.ip.message import Closed, Consumed, Ended, Portion, RelayMessage

Key = tuple[str, int]


class Channels:
    def __init__(self) -> None:
        self._channels: dict[Key, Channel] = {}

    def __len__(self) -> int:
        return len(self._channels)

    def add(self, key: Key, channel: Channel) -> None:
        self._channels[key] = channel

    def take(self, message: RelayMessage) -> bool:
        """Give a message to its channel.  Return true if there is one."""
        channel = self._of(message)
        if channel is None:
            return False
        assert isinstance(message, Portion | Consumed | Ended | Closed)
        channel.take(message)
        self.forget_if_over(channel, (message.opener, message.number))
        return True

    def lose(self, why: str) -> None:
        """Lose all channels, and tell their users."""
        channels, self._channels = self._channels, {}
        for channel in channels.values():
            if not channel.is_over:
                channel.abort()
                channel.on_close(why)

    def sent(self, message: RelayMessage) -> None:
        """Forget the channel of a message that was its last one."""
        channel = self._of(message)
        if channel is not None:
            assert isinstance(message, Portion | Consumed | Ended | Closed)
            self.forget_if_over(channel, (message.opener, message.number))

    def forget_if_over(self, channel: Channel, key: Key) -> None:
        if channel.is_over and self._channels.get(key) is channel:
            del self._channels[key]

    def _of(self, message: RelayMessage) -> Channel | None:
        if isinstance(message, Portion | Consumed | Ended | Closed):
            return self._channels.get((message.opener, message.number))
        return None
