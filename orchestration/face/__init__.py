"""What notebooks and scripts use: `import warmlink as wl`.

Each name is loaded when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from warmlink.controllers.design.linearise import linearise as linearise
    from warmlink.controllers.own import Law as Law
    from warmlink.fmus.component import Component as Component
    from warmlink.fmus.component import Input as Input
    from warmlink.fmus.component import Output as Output
    from warmlink.fmus.component import Parameter as Parameter
    from warmlink.fmus.component import State as State
    from warmlink.fmus.component.arithmetic import finite as finite
    from warmlink.fmus.component.arithmetic import where as where
    from warmlink.fmus.component.join import join as join
    from warmlink.fmus.errors import InputError as InputError
    from warmlink.fmus.packaging.release import version
    from warmlink.orchestration.check.checked import check as check
    from warmlink.orchestration.closed_loop.outcome import run as run
    from warmlink.orchestration.describe import describe as describe
    from warmlink.orchestration.diagnosis.made_up import hide_effects
    from warmlink.orchestration.fmu_store import fmu_files as fmu_files
    from warmlink.orchestration.paper.reproduce import reproduce as reproduce
    from warmlink.orchestration.products.build import build as build
    from warmlink.orchestration.products.cnc import cnc_table as cnc_table
    from warmlink.orchestration.products.compare import compare as compare
    from warmlink.orchestration.products.diagnose import diagnose as diagnose
    from warmlink.orchestration.products.export import export as export
    from warmlink.orchestration.products.live import live as live
    from warmlink.orchestration.products.reduce import reduce as reduce
    from warmlink.orchestration.products.watch import watch as watch
    from warmlink.orchestration.report.plot import plot as plot
    from warmlink.orchestration.simulation import simulate as simulate
    from warmlink.orchestration.studies.design import design as design
    from warmlink.orchestration.studies.session import RunOptions as RunOptions
    from warmlink.orchestration.studies.sweep import sweep_study
    from warmlink.orchestration.studies.tune import tune_study
    from warmlink.orchestration.system.assemble import assemble as assemble
    from warmlink.orchestration.system.assemble import read_system as read_system
    from warmlink.orchestration.system.write import write_ssp as write_ssp

    hide, sweep, tune = hide_effects, sweep_study, tune_study
    __version__ = version()

_PLACES = {
    "Component": "fmus.component:Component",
    "Input": "fmus.component:Input",
    "InputError": "fmus.errors:InputError",
    "Law": "controllers.own:Law",
    "Output": "fmus.component:Output",
    "Parameter": "fmus.component:Parameter",
    "RunOptions": "orchestration.studies.session:RunOptions",
    "State": "fmus.component:State",
    "assemble": "orchestration.system.assemble:assemble",
    "build": "orchestration.products.build:build",
    "check": "orchestration.check.checked:check",
    "cnc_table": "orchestration.products.cnc:cnc_table",
    "compare": "orchestration.products.compare:compare",
    "describe": "orchestration.describe:describe",
    "design": "orchestration.studies.design:design",
    "diagnose": "orchestration.products.diagnose:diagnose",
    "export": "orchestration.products.export:export",
    "finite": "fmus.component.arithmetic:finite",
    "fmu_files": "orchestration.fmu_store:fmu_files",
    "hide": "orchestration.diagnosis.made_up:hide_effects",
    "join": "fmus.component.join:join",
    "linearise": "controllers.design.linearise:linearise",
    "live": "orchestration.products.live:live",
    "plot": "orchestration.report.plot:plot",
    "read_system": "orchestration.system.assemble:read_system",
    "reduce": "orchestration.products.reduce:reduce",
    "reproduce": "orchestration.paper.reproduce:reproduce",
    "run": "orchestration.closed_loop.outcome:run",
    "simulate": "orchestration.simulation:simulate",
    "sweep": "orchestration.studies.sweep:sweep_study",
    "tune": "orchestration.studies.tune:tune_study",
    "watch": "orchestration.products.watch:watch",
    "where": "fmus.component.arithmetic:where",
    "write_ssp": "orchestration.system.write:write_ssp",
}
"""Module and name of everything public, below `warmlink`."""

__all__ = [*_PLACES, "__version__"]


def __getattr__(name: str) -> Any:
    """Load the object of this name."""
    if name == "__version__":
        from warmlink.fmus.packaging.release import version

        found: Any = version()
    elif name in _PLACES:
        module, _, attribute = _PLACES[name].partition(":")
        found = getattr(import_module(f"warmlink.{module}"), attribute)
    else:
        from warmlink.fmus.names import instead

        raise AttributeError(f"warmlink has no {name}; {instead(name, _PLACES)}")
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return __all__
