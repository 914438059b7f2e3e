# The path of docs/begin/begin.md from a wheel in an empty environment to the first test.  WHEEL is the wheel's file.
python3 -m venv .venv
. .venv/bin/activate
python -m pip install --quiet --disable-pip-version-check "$WHEEL" pytest
test "$(command -v fieldrig)" = "$PWD/.venv/bin/fieldrig"

fieldrig new | grep "^lab  .*the tank"
fieldrig new lab bench
fieldrig check bench/lab.yaml
python -m pytest -q bench | grep -x "2 passed in .*s"

# The first test of one's own, where the page says that it goes.
cat >> bench/test_lab.py <<'END'


def test_the_tank_is_a_quarter_full(fieldrig_rig: RigMaker) -> None:
    assert fieldrig_rig(RIG).get("tank", "level") == 0.5
END
python -m pytest -q bench | grep -x "3 passed in .*s"

cp bench/eds/level-sensor.eds my-sensor.eds
fieldrig new --eds my-sensor.eds
python -m pytest -q my-sensor | grep -x "2 passed in .*s"
