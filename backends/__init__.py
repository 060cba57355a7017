"""Solver backends: `get("highs").solve(model, SolveOptions())`.

A backend is found by its name among the built-in ones, then among the entry points of the group
`stlc.backends` (each names a class or function that is called without arguments). Nothing is
imported before it is asked for.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import cast

from stlc.backends.base import Backend
from stlc.errors import SolverError, UsageError, hinted

_BUILT_IN = {
    "highs": "highs:Highs",
    "mip": "python_mip:PythonMip",
    "pulp": "pulp_cbc:PulpCbc",
    "cvxpy": "cvxpy_highs:Cvxpy",
    "scipy": "scipy_milp:ScipyMilp",
    "scip": "scip:Scip",
    "gurobi": "gurobi:Gurobi",
}
_EXTERNAL = ("", "cbc", "glpsol", "scip", "highs", "cplex", "gurobi_cl", "fscip")
_ALIASES = {"cbc": "mip"}


def names() -> tuple[str, ...]:
    """Names of every backend known here, built-in ones first, whether installed or not."""
    own = (*_BUILT_IN, *map(_external_name, _EXTERNAL))
    return (*own, *sorted(set(_plugins()) - set(own)))


def get(name: str) -> Backend:
    """The backend of that name; UsageError for an unknown name, SolverError for a plugin that
    cannot load."""
    name = _ALIASES.get(name, name)
    if name in map(_external_name, _EXTERNAL):
        from stlc.backends.external import external

        return external(name.removeprefix("external").removeprefix("-"))
    if name in _BUILT_IN:
        module, attribute = _BUILT_IN[name].split(":")
        return cast(Backend, getattr(import_module(f"{__name__}.{module}"), attribute)())
    plugin = _plugins().get(name)
    if plugin is None:
        raise _unknown(name)
    return _load(plugin)


def _unknown(name: str) -> UsageError:
    return UsageError(f"there is no backend '{name}'; {hinted(name, names())}")


def _external_name(template: str) -> str:
    return f"external-{template}" if template else "external"


def _plugins() -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group="stlc.backends")}


def _load(plugin: EntryPoint) -> Backend:
    try:
        backend = plugin.load()()
    except (ImportError, AttributeError) as error:
        raise SolverError(f"backend '{plugin.name}' could not be loaded: {error}") from error
    if not isinstance(backend, Backend):
        raise SolverError(f"backend '{plugin.name}' ({plugin.value}) is not a Backend")
    return backend
