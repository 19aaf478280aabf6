"""What a simulation's arrays leave is there for the next one's."""

import platform

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.model.memory import keep_memory


@pytest.mark.platform
@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another C library than glibc")
def test_arrays_that_are_made_again_and_again_fetch_no_memory() -> None:
    """Each time they fetched 60 MB, page by page."""
    import resource  # which Windows lacks

    keep_memory()
    for _ in range(3):
        begun = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
        arrays = [np.ones(1 << 20) for _ in range(8)]
        del arrays
    assert resource.getrusage(resource.RUSAGE_SELF).ru_minflt - begun < 100
