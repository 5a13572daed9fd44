"""Follow the loading path from the state under dead load to collapse.

Joints are slightly elastic.
"""

from collections.abc import Generator
from dataclasses import replace

import numpy as np

from blockstruct.arrays import Array
from blockstruct.limit.iteration import Found, Iteration
from blockstruct.limit.program import ConicProgram, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.carried_forces import carried_forces
from blockstruct.procedures.closing import CLOSED, close_path
from blockstruct.procedures.interior_point_path import InteriorPointPath
from blockstruct.procedures.path import ATTEMPTS, SETTLED, Path
from blockstruct.procedures.splitting_path import SplittingPath
from blockstruct.vocabulary import PathEnd, Procedure

#: Flow-rule gap of a settled step, relative to the load factor, above which the next step is solved with care before
#: the path is closed, and its forces are corrected first.
INEXACT = SETTLED


def path_of(program: ConicProgram, settings: ProcedureSettings) -> Path:
    """Return the path of the settings at its beginning."""
    return _KINDS[settings.path_steps](program, settings)


_KINDS: dict[str, type[Path]] = {"splitting": SplittingPath, "interior point": InteriorPointPath}


def loading_path(
    path: Path, bound: float, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, tuple[PathEnd, Found | None]]:
    """Follow the loading path to its end and close it.

    The path is followed until its load factor no longer changes. Its last state is still slightly elastic; to close
    the path is to replace this state by an exact, rigid one. A collapse state without dilatancy is not unique: it
    depends on how the structure is loaded. Each step prescribes the displacement of the variable load and finds
    forces, displacements and load factor (:class:`~blockstruct.procedures.path.Path`). The contacts remember openings
    and friction forces.
    Compare A. Orduña, P. B. Lourenço, "Three-dimensional limit analysis of rigid blocks assemblages. Part II", Int. J.
    Solids Struct. 42 (2005) 5161–5180, doi:10.1016/j.ijsolstr.2005.02.011.

    The path ends once the load factor has hardly changed while the displacement grew tenfold. Its displacements still
    contain some elastic strain, which no rigid mechanism has. An exact mechanism and its forces therefore close the
    path (:func:`~blockstruct.procedures.closing.close_path`). First, the friction limit of each contact is fixed at
    ``μ`` times its normal force on the path, and the largest load gives the mechanism. Then, of all admissible forces,
    those with the smallest flow-rule gap for this mechanism are taken. If the load factor of the closed state differs
    from the path, the path advances further and is closed again, up to ``ATTEMPTS`` times.

    If it still differs, or if the path does not finish, the whole path is repeated with steps half as long, and at last
    with steps of the other kind. Shorter steps take more iterations, so a path that used up its iterations is not
    repeated with them.

    Parameters
    ----------
    path
        The path, at its beginning.
    bound
        Load factor with associative flow, which the path hardly passes; infinite without one. It scales the first guess
        and the largest displacement.
    settings, solver
        Tolerances of the certificate, and the solver of programs that close the path.

    Yields
    ------
    Iteration
        The state under dead load, each step with its displacement, and the programs that close the path.

    Returns
    -------
    PathEnd, Found or None
        How the path ended, and a state: the certified one if the path is closed; the last step, without a certificate,
        if the load factor never settles; otherwise None.
    """
    end, found = yield from _followed(path, bound, settings, solver)
    (other,) = _KINDS.keys() - {settings.path_steps}
    half_steps = (settings, 2)
    other_kind = (replace(settings, path_steps=other), 1)
    for attempt, divisor in (half_steps, other_kind):
        if end is PathEnd.CLOSED and found is not None and found.settled:
            break
        if divisor > 1 and path.is_exhausted:
            continue
        repeated = _KINDS[attempt.path_steps](path.program, attempt, divisor)
        latest_end, latest = yield from _followed(repeated, bound, attempt, solver)
        if latest_end is PathEnd.CLOSED and latest is not None and (end is not PathEnd.CLOSED or latest.settled):
            end, found = latest_end, latest
    return end, found


def _followed(
    path: Path, bound: float, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, tuple[PathEnd, Found | None]]:
    """Follow one path."""
    last = path.dead_load
    if last is None:
        return PathEnd.NO_DEAD_LOAD_STATE, None
    yield last
    best: Found | None = None
    exact, attempts = False, 0
    while not exact and attempts < ATTEMPTS:
        last, settled = yield from _until_settled(path, last, bound, careful=attempts > 0)
        if not settled:
            # The path has left the plateau on which it was closed.
            best = None if best is None else replace(_found(path, best.state), settled=False)
            break
        forces, previous_gap, is_promising = _near(path, last), np.inf, True
        while is_promising and attempts < ATTEMPTS:
            closed = yield from close_path(path, forces, settings, solver)
            attempts += 1
            gap = path.gap(closed)
            if closed.certificate.holds:
                found = _found(path, closed)
                if best is None or (found.settled, -gap) > (best.settled, -path.gap(best.state)):
                    best = found
            # A state that is closed again from its own forces has a smaller gap. The first repetition is always made,
            # a later one if another reduction by the same ratio is enough.
            is_promising = gap > CLOSED and gap * (gap / previous_gap) <= CLOSED
            forces, previous_gap = closed.x, gap
        exact = best is not None and best.settled and path.gap(best.state) <= CLOSED
        path.refine()
    if best is not None:
        return PathEnd.CLOSED, best
    if attempts:
        return PathEnd.NOT_CERTIFIED, None
    if path.end is PathEnd.LIMIT_REACHED:
        return path.end, Found(last, Procedure.LOADING_PATH, settled=False, drift=path.drift)
    return path.end, None


def _until_settled(
    path: Path, last: Iteration, bound: float, *, careful: bool
) -> Generator[Iteration, None, tuple[Iteration, bool]]:
    """Follow a path until its load factor has settled.

    If a settled step is not exact, one more step is solved with care, unless all steps are. Return the last step, and
    whether it has settled.
    """
    settled = False
    while (step := path.advance(bound)) is not None:
        yield step
        last, settled = step, path.has_settled(step)
        if settled and (careful or path.gap(step) <= INEXACT):
            break
        if settled:
            careful = True
            path.refine()
    return last, settled


def _near(path: Path, last: Iteration) -> Array:
    """Return the forces (K, 3) that a path is closed from.

    Forces of a step that is not exact exceed friction where blocks slide, by a thousandth of the mean force. Friction
    frozen there carries less than the path. The nearest forces within friction replace them, at the load factor that
    follows from them.
    """
    problem = path.program.problem
    if path.gap(last) <= INEXACT or not problem.is_plain:
        return path.forces(last)
    x = carried_forces(problem.A, problem.friction, last.x, -problem.w_D, load=problem.w_L, alpha=last.load_factor)
    return path.forces(last) if x is None else x


def _found(path: Path, closed: Iteration) -> Found:
    """Return the closed state, settled if its load factor fits the path."""
    low, high = path.drift
    around = SETTLED * path.scale(closed)
    return Found(
        closed,
        Procedure.LOADING_PATH,
        settled=low - around <= closed.load_factor <= high + around,
        drift=(min(low, closed.load_factor), max(high, closed.load_factor)),
        peak=path.peak if path.peak > max(high, closed.load_factor) + around else np.nan,
    )
