"""Selection of iterations, interfaces and cases for views."""

import operator

import numpy as np

import blockstruct as bs
from blockstruct.arrays import Array, Index


def chosen_iteration(result: bs.CaseResult, iteration: int = -1) -> int:
    """Return the index of an iteration from zero; a negative one counts from the end.

    Raises
    ------
    ModelError
        If the case has no iterations, or the iteration is not an integer.
    UnknownNameError
        If the case does not have the iteration.
    """
    n = result.n_iterations
    if n == 0:
        why = f"no iteration to show, {result.headline}; run the case again"
        msg = f"case {result.name!r}: {why if result.response is None else 'a record has states, but no iterations'}"
        raise bs.errors.ModelError(msg)
    try:
        index = operator.index(iteration)
    except TypeError:
        msg = f"case {result.name!r}: iteration {iteration!r} is not an integer; give 0 to {n - 1} (-1 is the last)"
        raise bs.errors.ModelError(msg) from None
    if not -n <= index < n:
        msg = f"case {result.name!r}: no iteration {iteration}; it has 0 to {n - 1} (-1 is the last)"
        raise bs.errors.UnknownNameError(msg)
    return index % n


def chosen_interface(model: bs.Model, name: str) -> int:
    """Return the index of an interface.

    Raises
    ------
    UnknownNameError
        If no interface has the name.
    """
    names = [i.name for i in model.interfaces]
    bs.errors.check_known(name, names, f"model {model.name!r}: no interface")
    return names.index(name)


def given_result(result: object, what: str) -> bs.CaseResult:
    """Return the argument of a view if it is a result.

    Raises
    ------
    ModelError
        If it is anything else.
    """
    if isinstance(result, bs.CaseResult):
        return result
    msg = (
        f"{what}: {type(result).__name__} is not a result; give the CaseResult of a case, analysis['name of the case']"
    )
    raise bs.errors.ModelError(msg)


def application_points(result: bs.CaseResult, iteration: int) -> tuple[Array, Array]:
    """Return points (I, 3) in m of compressed interfaces, else NaN, and forces (I, 3) in N.

    Forces act on the plus blocks, in global axes. Compression within rounding does not count.
    """
    history = result.history.isel(iteration=[iteration])
    resultants = bs.results.interface_resultants(history)
    pressed = bs.results.is_pressed(history, resultants)[0]
    resultants = resultants.isel(iteration=0)
    frame = history["interface_frame"].to_numpy()
    e = resultants["eccentricity"].transpose("interface", "in_plane").to_numpy()
    force = resultants["force"].transpose("interface", "component").to_numpy()
    point = history["interface_position"].to_numpy() + np.einsum("ij,ija->ia", e, frame[:, 1:])
    point[~pressed] = np.nan
    return point, np.einsum("ic,ica->ia", force, frame)


def moving_bodies(result: bs.CaseResult, iteration: int) -> tuple[Index, list[bs.results.MacroBlock]]:
    """Return the macro-block (B,) of each block, −1 at rest, and the moving ones by weight."""
    bodies = bs.results.macro_blocks(
        result.model, bs.results.mechanism(result.history.isel(iteration=[iteration])), dead=result.case.dead
    )
    moving = [body for body in bodies if body.moves]
    number = {name: k for k, body in enumerate(moving) for name in body.blocks}
    return np.array([number.get(b.name, -1) for b in result.model.blocks], dtype=np.int64), moving


def shown_results(analysis: bs.Analysis) -> list[bs.CaseResult]:
    """Return one result of each case, without the other runs of spreads."""
    return [analysis[name] for name in analysis.headlines]


def compasses(analysis: bs.Analysis) -> list[tuple[str, bs.studies.Directions]]:
    """Return the directions of each case with directions, or of three pushes or more.

    Raises
    ------
    ModelError
        As of :meth:`blockstruct.studies.Directions.each_of`.
    """
    each = bs.studies.Directions.each_of(analysis)
    if each:
        return each
    try:
        around = bs.studies.Directions.of(analysis)
    except bs.errors.ModelError:
        return []
    return [(analysis.model.name, around)] if around.data.sizes["direction"] > 2 else []
