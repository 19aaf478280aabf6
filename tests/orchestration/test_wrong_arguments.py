"""What a Python call is given in place of a path, names or a number ends in one sentence."""

from collections.abc import Callable

import pytest

import warmlink as wl
from warmlink.fmus.errors import InputError


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: wl.run(parameters=None), "parameters=None: is no path"),
        (lambda: wl.run(mismatches=None), "None: is neither a name nor a list of names"),
        (lambda: wl.run(master=3), "master: 3 is not known"),
        (lambda: wl.simulate(None), "system=None: is no path"),
        (lambda: wl.read_system(None), "path=None: is no path"),
        (lambda: wl.check(None), "file=None: is no path"),
        (lambda: wl.describe(None), "what=None: is no path"),
        (lambda: wl.design(None), "system=None: is no path"),
        (lambda: wl.design(parameters=None), "parameters=None: is no path"),
        (lambda: wl.design(law=None), "law=None: has no design"),
        (lambda: wl.export("lag", 3), "design=3: is no path"),
        (lambda: wl.live(None), "scenario=None: is no path"),
        (lambda: wl.diagnose(None), "data=None: is no path"),
        (lambda: wl.plot(None), "results=None: is no path"),
        (lambda: wl.tune("lag_law", "3"), "trials='3': not a number of trials; give a whole number from 1"),
        (lambda: wl.tune("lag_law", options=wl.RunOptions(jobs="2")), "jobs='2': not a number of processes"),
        (lambda: wl.reduce(__file__, "#1", "0, 0, 0 mm", order="3"), "order='3': not a number of patterns"),
        (lambda: wl.build(ssp=3), "ssp=3: no such version; choose 1 or 2"),
    ],
)
def test_it_is_named_and_what_to_give_instead(call: Callable[[], object], sentence: str) -> None:
    with pytest.raises(InputError) as refusal:
        call()
    assert str(refusal.value).startswith(sentence)
