"""Check that the name of a plugin is unique."""

from gaitsim.plugin import Entry
from gaitsim_testing.finding import require
from gaitsim_testing.packages import CHECKED, other_claims

KINDS = CHECKED


def test_name(entry: Entry) -> None:
    """No other package registers the name."""
    others = other_claims(entry)
    require(
        not others,
        f"also registered by {' and '.join(others)}",
        f"a unique name: if several packages register {entry.name!r}, none can be used",
        "choose a different name in the entry points",
    )
