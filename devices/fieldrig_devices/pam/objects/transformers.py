"""Amplifiers, cams, derivators, distributors and phasers in programs (sections 2.19 to 2.26 of the digest)."""

from collections.abc import Callable, Sequence
from typing import Any

from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pam.objects.object_item import ObjectItem
from fieldrig_devices.pam.objects.parameters import OfBlock, PeriodOfBlock, SlewedOfBlock, SlopeOfBlock
from fieldrig_devices.pam.objects.site import Site
from fieldrig_devices.pam.objects.transformer_item import TransformerItem
from fieldrig_devices.pam.pipes.amplifier import Amplifier
from fieldrig_devices.pam.pipes.cam import Cam, Profile, Shape
from fieldrig_devices.pam.pipes.derivator import Derivator
from fieldrig_devices.pam.pipes.distributor import Distributor
from fieldrig_devices.pam.pipes.phaser import Phaser


class AmplifierItem(TransformerItem):
    block: Amplifier
    gain, gain_slope = SlewedOfBlock("gain"), SlopeOfBlock("gain")
    offset, offset_slope = SlewedOfBlock("offset"), SlopeOfBlock("offset")

    def __init__(self, declared: Declared, site: Site) -> None:
        super().__init__(declared, site)
        self.block = Amplifier(0.0, 0.0, unwraps=site.readings.amplifier_unwraps)
        self.declare(declared)

    def declare(self, declared: Declared) -> None:
        self.gain, self.offset = declared.number("GAIN"), declared.number("OFFSET")
        self.gain_slope, self.offset_slope = declared.optional("GAIN_SLOPE"), declared.optional("OFFSET_SLOPE")


class ProfileItem(ObjectItem):
    """A shape with its amplitudes and offsets.  A cam takes them over when its PROFILE is written (PAML-444)."""

    def __init__(self, declared: Declared, shape: Shape, followers: "Sequence[CamItem]" = ()) -> None:
        """`followers` are cams that take a change of their profile over at once (E-05)."""
        super().__init__(declared.name)
        self._shape, self._followers = shape, followers
        self.input_amplitude, self.output_amplitude = (
            declared.number("INPUT_AMPLITUDE"),
            declared.number("OUTPUT_AMPLITUDE"),
        )
        self.input_offset, self.output_offset = declared.number("INPUT_OFFSET"), declared.number("OUTPUT_OFFSET")

    def set_parameter(self, name: str, value: Any) -> None:
        super().set_parameter(name, value)
        for cam in self._followers:
            if cam.profile is self:
                cam.set_parameter("PROFILE", self)

    def taken(self) -> Profile:
        """Return the profile as it is now."""
        sizes = (self.input_amplitude, self.output_amplitude, self.input_offset, self.output_offset)
        return Profile(self._shape, *map(float, sizes))


class CamItem(TransformerItem):
    block: Cam
    value_period = PeriodOfBlock("value_period")

    def __init__(
        self, declared: Declared, site: Site, profile: ProfileItem, find: Callable[[str], ProfileItem]
    ) -> None:
        super().__init__(declared, site)
        self._profile, self._find = profile, find
        self.block = Cam(profile.taken(), declared.number("VALUE_PERIOD") or None)

    def declare(self, declared: Declared) -> None:
        self._profile = self._find(declared.reference("PROFILE"))

    def begin(self, period_s: float) -> None:
        self.block.profile = self._profile.taken()
        super().begin(period_s)

    @property
    def profile(self) -> ProfileItem:
        return self._profile

    @profile.setter
    def profile(self, profile: ProfileItem) -> None:
        self._profile = profile
        self.block.profile = profile.taken()


class DerivatorItem(TransformerItem):
    block: Derivator
    value_period = PeriodOfBlock("value_period")

    def __init__(self, declared: Declared, site: Site) -> None:
        super().__init__(declared, site)
        self.block = Derivator(declared.number("VALUE_PERIOD") or None)


class DistributorItem(TransformerItem):
    block: Distributor

    def __init__(self, declared: Declared, site: Site) -> None:
        super().__init__(declared, site)
        self.block = Distributor(declared.integer("DIVISOR"), declared.integer("SHIFT"))


class PhaserItem(TransformerItem):
    block: Phaser
    phase, phase_slope = SlewedOfBlock("phase"), SlopeOfBlock("phase")
    standby_value = OfBlock("standby_value")
    value_period = PeriodOfBlock("value_period")

    def __init__(self, declared: Declared, site: Site) -> None:
        super().__init__(declared, site)
        self.block = Phaser(0.0, None, 0.0, declared.number("VALUE_PERIOD"))
        self.declare(declared)

    def declare(self, declared: Declared) -> None:
        self.phase, self.standby_value = declared.number("PHASE"), declared.number("STANDBY_VALUE")
        self.phase_slope = declared.optional("PHASE_SLOPE")

    def do_start(self) -> None:
        self.block.command_start()

    def do_stop(self) -> None:
        self.block.command_stop()
