"""A dialect is a set of origins, and one line for each real difference from them."""

from dataclasses import asdict

import pytest

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect, Origin


def test_a_further_dialect_differs_only_in_what_it_states() -> None:
    further = Dialect.of("further", Origin.TODAY, Origin.ANY_CODESYS, Origin.TOOLS, has_real_powers=False)
    differences = {name for name, value in asdict(further).items() if value != asdict(CODESYS)[name]}
    assert differences == {"name", "has_real_powers"}


def test_a_difference_that_no_dialect_knows_is_refused() -> None:
    with pytest.raises(TypeError, match="has_real_power"):
        Dialect.of("further", Origin.TODAY, has_real_power=False)


def test_tools_keep_the_rules_of_epas_4_that_the_standard_dropped() -> None:
    for rule in ("mixes_integers", "computes_in_32_bits", "allows_calls_without_brackets"):
        assert [getattr(dialect, rule) for dialect in (EPAS_4, EDITION_3, CODESYS)] == [True, False, True]
