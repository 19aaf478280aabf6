"""The browsers that a page is tried in: each is started once for a file of tests."""

from collections.abc import Iterator

import pytest

from tests.browser import Browser
from tests.chromium import Chromium
from tests.firefox import Firefox


@pytest.fixture(scope="module", params=[Chromium, Firefox], ids=["chromium", "firefox"])
def browser(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    # No page can be made without it, so that no browser need start.
    pytest.importorskip("ziglang", reason='ziglang is not installed: pip install "warmlink[live]"')
    with request.param.started(tmp_path_factory.mktemp("browser")) as opened:
        yield opened
