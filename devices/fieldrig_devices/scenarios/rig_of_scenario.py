"""The rig of a scenario: its file with the values beside it, whose mistakes have the line of the scenario."""

from collections.abc import Iterator, Sequence

from fieldrig.config.rig_file import RigConfig, load
from fieldrig.config.source import TYPED
from fieldrig.config.yaml_source import KeyPath, Source, key_text
from fieldrig.errors import ConfigError, Mistake
from fieldrig_devices.scenarios.scenario_file import Scenario


def config_of(scenario: Scenario, overrides: Sequence[str] = (), time: str = "virtual") -> RigConfig:
    """Return the rig of a scenario, with further overrides.  ConfigError with its mistakes."""
    try:
        return load(scenario.rig, (*scenario.overrides, *overrides, f"time={time}"))
    except ConfigError as wrong:
        source = scenario.source or Source()
        raise ConfigError([_placed(source, one) for one in wrong.mistakes]) from wrong


def _placed(source: Source, mistake: Mistake) -> Mistake:
    """Return a mistake in a value beside the rig file with the line of the scenario that has it, if one has."""
    typed = mistake.file.removeprefix(TYPED)
    path = next((path for path, words in _beside(source) if words == typed), None) if typed != mistake.file else None
    if path is None:
        return mistake
    what = f"{mistake.key}: {mistake.what}" if mistake.key else mistake.what
    return Mistake(*source.mark(path), key_text(path), what, mistake.remedy)


def _beside(source: Source) -> Iterator[tuple[KeyPath, str]]:
    """Yield the values beside the rig file, with their keys: those of a scenario, and the worlds of a plan."""
    data = source.data if isinstance(source.data, dict) else {}
    for number, words in enumerate(data.get("overrides") or ()):
        yield ("overrides", number), str(words)
    for key, values in (data.get("worlds") or {}).items():
        for number, value in enumerate(values):
            yield ("worlds", key, number), f"{key}={value}"
