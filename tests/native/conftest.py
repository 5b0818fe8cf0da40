"""What several test files of the core build once."""

import pytest
from bentlight_native import DeflectionTable
from tables import SPACETIMES


@pytest.fixture(scope="session", params=SPACETIMES, ids=list(SPACETIMES))
def table(request):
    """The deflection table of each spacetime that has one."""
    return DeflectionTable(SPACETIMES[request.param])
