"""C of a joined component: each kind of part once, and the wires between the parts.

Written out whole, six observers would be six times 16,000 lines. So the functions of a kind are written
once, and called with the place of each part in the vectors of the whole.
"""

from collections.abc import Iterator

from warmlink.fmus.component import Component
from warmlink.fmus.component.join import Joint
from warmlink.fmus.packaging.native.casadi_code import Expression, Function, beginning, sampling


def starting_parts(component: Component, joint: Joint, now: list[Expression]) -> Iterator[Function]:
    """Yield what the parts need at the start: settling and beginning of each kind, inputs of each part.

    Symbols are those of the whole's states, inputs, settled parameters and time `now`.
    """
    import casadi

    for kind in kinds(joint).values():
        p = casadi.SX.sym("p", kind.p.size)
        yield f"settle_{kind.name}", [p], kind.settled(p)
        yield from beginning(kind, f"_{kind.name}")
    x, u = now[0], now[1]
    dx, du = casadi.SX.sym("dx", x.numel()), casadi.SX.sym("du", u.numel())
    for number, (key, part) in enumerate(joint.parts.items()):
        if part.states:
            inputs = casadi.SX(_inputs(component, joint, key, now))
            slope = casadi.jtimes(inputs, casadi.vertcat(x, u), casadi.vertcat(dx, du))
            yield f"inputs_{number}", now, inputs
            yield f"inputs_tangent_{number}", [*now, dx, du], slope


def running_parts(component: Component, joint: Joint, now: list[Expression]) -> Iterator[Function]:
    """Yield what the sampled parts need: the sample of each kind, the inputs of each part."""
    for kind in kinds(joint).values():
        for clock in range(len(kind.clocks)):
            yield sampling(kind, clock, f"update_{kind.name}")
    for number, (key, part) in enumerate(joint.parts.items()):
        if part.sampled:
            yield f"inputs_{number}", now, _inputs(component, joint, key, now)


def starting_glue(component: Component, joint: Joint) -> str:
    """C functions `settle`, `begin` and `begin_tangent` of the whole."""
    settle = ""
    passes: dict[str, tuple[str, str]] = {}
    for number, (key, part) in enumerate(joint.parts.items()):
        p, d, x = places(component, key, part)
        settle += f"    settle_{part.name}_of(p + {p}, d + {d});\n"
        size = max(part.u.size, 1)
        values = f"double v[{size}]; inputs_{number}_of(x, u, d, &time, v);"
        passes[key] = (
            f"    {{ {values} begin_{part.name}_of(v, d + {d}, x + {x}); }}\n",
            f"    {{ {values} double w[{size}]; inputs_tangent_{number}_of(x, u, d, &time, dx, du, w);"
            f" begin_tangent_{part.name}_of(v, d + {d}, w, dx + {x}); }}\n",
        )
    begin, tangent = ("".join(passes[key][i] for key in joint.starting) for i in (0, 1))
    zero = "    const double time = 0;\n    for (int i = 0; i < WL_STATES; i++)\n"
    return (
        f"\nvoid WL(settle)(const double *p, double *d)\n{{\n{settle}}}\n"
        "\n/* Parts that wait for each other's first outputs begin more than once. */\n"
        f"void WL(begin)(const double *u, const double *d, double *x)\n{{\n{zero}        x[i] = 0;\n"
        f"{begin}}}\n"
        "\nvoid WL(begin_tangent)(const double *u, const double *d, const double *du, double *dx)\n"
        f"{{\n    double x[WL_STATES];\n{zero}        dx[i] = 0;\n    WL(begin)(u, d, x);\n{tangent}}}\n"
    )


def sample_glue(component: Component, joint: Joint) -> str:
    """C functions `sample_0_of` and so on: what each clock does."""
    parts: list[str] = []
    for number, (key, part) in enumerate(joint.parts.items()):
        if not part.sampled:
            continue
        _, d, x = places(component, key, part)
        parts.append(
            f"\nstatic void sample_{len(parts)}_of(const double *x, const double *u, const double *d,"
            f" const double *time, const double *step, double *result)\n{{\n"
            f"    double v[{max(part.u.size, 1)}];\n    inputs_{number}_of(x, u, d, time, v);\n"
            f"    update_{part.name}_0_of(x + {x}, v, d + {d}, time, step, result);\n}}\n"
        )
    return "".join(parts)


def _inputs(component: Component, joint: Joint, key: str, now: list[Expression]) -> Expression:
    """Flat inputs of a part as expressions of the whole's symbols."""
    x, u, d, time = now
    return joint.inputs(key, component.x.read(x), component.u.read(u), component.d.read(d), time)


def kinds(joint: Joint) -> dict[str, Component]:
    """The declarations behind the parts by name, each once."""
    return {part.name: part for part in joint.parts.values()}


def places(component: Component, key: str, part: Component) -> tuple[int, int, int]:
    """Where a part's parameters, what they settle, and its states begin in the vectors of the whole."""
    layouts = ((component.p, part.p), (component.d, part.d), (component.x, part.x))
    p, d, x = (whole.index[f"{key}.{own.names[0]}"] if own.size else 0 for whole, own in layouts)
    return p, d, x
