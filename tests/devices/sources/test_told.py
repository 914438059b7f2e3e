"""A mistake in values that live by themselves comes with file, line, key, and a remedy that helps or none."""

from pathlib import Path

import pytest

from fieldrig.config.build import try_devices
from fieldrig.config.rig_file import look_through

EDS = Path(__file__).parents[3] / "configs" / "eds" / "io32.eds"
NODE = f"""buses:
  can0: {{kind: can.virtual, bitrate: 1000000}}
devices:
  io:
    kind: canopen.node
    node_id: 3
    eds: {EDS}
    links: {{can: can0}}
    sources:
      "6401:01": SOURCE"""
WIRES = """buses:
  wires: {kind: wires.virtual}
devices:
  io:
    kind: plant.signals
    links: {wires: wires}
    signals:
      level:
        source: SOURCE"""
TABLE = """buses:
  line: {kind: modbus.virtual}
devices:
  io:
    kind: modbus.device
    links: {modbus: line}
    units:
      1: {table: table.yaml}"""
KINDS = {"node": NODE, "wires": WIRES, "table": TABLE}


def mistakes(folder: Path, form: str, source: str) -> list[tuple[str, int | None, str, str, str]]:
    """File, line, last keys, what is wrong and remedy, of this source at one of its places."""
    (folder / "bad.csv").write_text("a;b\nx;1\n")
    text = "time: virtual\n" + KINDS[form]
    (folder / "rig.yaml").write_text(text.replace("SOURCE", source))
    (folder / "table.yaml").write_text(f"input_registers:\n  - name: flow\n    address: 1\n    source: {source}")
    _, devices, found = look_through(folder / "rig.yaml")
    found += try_devices(devices)
    return [(Path(at.file).name, at.line, at.key, at.what, at.remedy) for at in found]


@pytest.mark.parametrize("form", KINDS)
@pytest.mark.parametrize(
    ("source", "key", "what", "remedy"),
    [
        ("{kind: sine, low: 2, high: 1, period_ms: 5}", "low", "low 2 is above high 1", "expected at most high"),
        ("{kind: square, low: 2, period_ms: 5}", "low", "low 2 is above high 1", "expected at most high, which is 1"),
        ("{kind: square, high: -1, period_ms: 5}", "high", "low 0 is above high -1", "expected at most high"),
        ("{kind: replay, file: bad.csv, column: a}", "file", "bad.csv: line 2: expected a number in column 'a'", ""),
        ("{kind: sin, period_ms: 5}", "kind", '"sin" doesn\'t fit', "did you mean sine?"),
        ("{kind: counter}", "per_s", "this key is missing", "expected a number"),
        ("{kind: square, period_ms: 5, high_percent: 0}", "high_percent", "0 doesn't fit", "expected a number above 0"),
        ("{kind: uptime, every: 5}", "every", "there is no such key", "there are: kind, unit_ms"),
        ("{period_ms: 5}", "kind", "this key is missing", "expected clock or constant or counter or"),
    ],
)  # fmt: skip
def test_a_wrong_key_of_a_source(tmp_path: Path, form: str, source: str, key: str, what: str, remedy: str) -> None:
    ((file, line, where, told, wanted),) = mistakes(tmp_path, form, source)
    last = (tmp_path / file).read_text().count("\n") + 1
    assert (file, line) == ("table.yaml" if form == "table" else "rig.yaml", last)
    assert (where.rsplit(".", 1)[-1], told[: len(what)]) == (key, what)
    assert wanted.startswith(remedy)
    assert bool(wanted) is bool(remedy)


@pytest.mark.parametrize(
    ("key", "what"),
    [
        ("7000:01", "the EDS has no 7000:01"),
        ("1008:00", "1008:00 is VISIBLE_STRING"),
        ("six", "'six' is not an object"),
    ],
)
def test_an_object_that_cannot_live(tmp_path: Path, key: str, what: str) -> None:
    (tmp_path / "rig.yaml").write_text(
        ("time: virtual\n" + NODE).replace("6401:01", key).replace("SOURCE", "{kind: uptime}")
    )
    (mistake,) = look_through(tmp_path / "rig.yaml")[2]
    assert mistake.line == NODE.count("\n") + 2
    assert mistake.key == f"devices.io.sources.{key}"
    assert mistake.what.startswith(what)
    assert "mapping" not in str(mistake)
