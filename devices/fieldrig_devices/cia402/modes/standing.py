"""A mode of operation of the maker: it can be chosen and is shown, and the axis comes to rest and stands.

Source: CiA 402-2, 6060h: -1 to -128 belong to the makers.  Nothing says what such a mode does.
"""

from fieldrig_devices.cia402.modes.mode import Mode


class Standing(Mode):
    def begin(self) -> None:
        self.come_to_rest()
