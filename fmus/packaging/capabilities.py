"""What an FMU can be instantiated as, and what it can do."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree as ET

from warmlink.fmus.packaging.attributes import text


@dataclass(frozen=True)
class Capabilities:
    """What the form of an FMU can do beyond what every one of ours can.

    All of them get, set and serialise their state, take any communication step size, and need no tool.

    Attributes
    ----------
    directional_derivatives : fmi2GetDirectionalDerivative or fmi3GetDirectionalDerivative works
    interpolates_inputs : FMI 2.0: input derivatives act within the step
    output_derivative_order : highest order of output derivatives
    intermediate_update : FMI 3.0: continuous inputs may be set within the step, and the step ended early
    own_memory_only : FMI 2.0: the host's memory callbacks are not used
    model_exchange : hosts may integrate the states themselves
    """

    directional_derivatives: bool = False
    interpolates_inputs: bool = False
    output_derivative_order: int = 0
    intermediate_update: bool = False
    own_memory_only: bool = False
    model_exchange: bool = False


def interfaces(
    root: ET.Element,
    identifier: str,
    capabilities: Capabilities,
    flags: dict[str, bool],
    stepping: dict[str, bool],
    exchanging: dict[str, bool],
) -> list[ET.Element]:
    """Add what the FMU can be instantiated as: for model exchange where it can, and for co-simulation."""
    order = capabilities.output_derivative_order
    derivatives = {"maxOutputDerivativeOrder": str(order)} if order else {}
    kinds: list[tuple[str, dict[str, bool], dict[str, str]]] = (
        [("ModelExchange", exchanging, {})] if capabilities.model_exchange else []
    )
    return [
        ET.SubElement(
            root,
            kind,
            {"modelIdentifier": identifier, "needsExecutionTool": "false"}
            | {name: text(flag) for name, flag in (flags | own).items()}
            | more,
        )
        for kind, own, more in [*kinds, ("CoSimulation", stepping, derivatives)]
    ]
