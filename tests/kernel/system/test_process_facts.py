"""The facts of a process that can be asked for all the time."""

from fieldrig.system.this_process import brief_facts, facts


def test_the_brief_facts_leave_out_only_the_memory_that_is_looked_at_page_by_page() -> None:
    assert facts().keys() - brief_facts().keys() == {"own_mb"}
    assert brief_facts().keys() - facts().keys() == set()
