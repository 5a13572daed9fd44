"""The attack tells its trials, and ends with one table: ``pytest tests/attack -m "slow or not slow"``."""

from collections import Counter

import pytest

#: Columns of the table, and the outcomes that they count.
COLUMNS = {
    "right": ("answered", "identical", "resumed", "escaped"),
    "refused": ("refused",),
    "hang": ("hang", "slow"),
    "raw": ("raw", "crash", "long message"),
    "wrong": ("wrong",),
}


@pytest.fixture
def tell(record_property):
    """Function that counts trials by their outcome, and passes if all are right or refused."""

    def told(what, outcomes):
        outcomes = Counter(outcomes)
        assert set(outcomes) <= {name for names in COLUMNS.values() for name in names}
        record_property("attack", [what, {c: sum(outcomes[n] for n in names) for c, names in COLUMNS.items()}])
        assert sum(outcomes[n] for c in ("hang", "raw", "wrong") for n in COLUMNS[c]) == 0, (what, outcomes)

    return told


def pytest_terminal_summary(terminalreporter):
    table: dict[str, Counter] = {}
    for reports in terminalreporter.stats.values():
        for report in reports:
            for name, value in getattr(report, "user_properties", []):
                if name == "attack" and report.when == "teardown":
                    table.setdefault(value[0], Counter()).update(value[1])
    if not table:
        return
    terminalreporter.section("attack")
    terminalreporter.write_line(f"{'':<34}{'trials':>8}" + "".join(f"{column:>9}" for column in COLUMNS))
    table["all"] = sum(table.values(), Counter())
    for what, counts in table.items():
        cells = "".join(f"{counts[column]:>9}" for column in COLUMNS)
        terminalreporter.write_line(f"{what:<34}{sum(counts.values()):>8}{cells}")
