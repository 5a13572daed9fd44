"""The N–M point of an interface in its crushing domain."""

import math

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

import blockstruct as bs
from blockstruct.units import readable
from blockstruct.views.figures.canvas import new_axes, verbatim
from blockstruct.views.selection import chosen_interface, chosen_iteration, given_result
from blockstruct.views.style import ACCENT, FORCE

Array = NDArray[np.float64]

_CUTS = 65


def crushing_domain(
    result: bs.CaseResult, interface: str, *, about: str = "s", iteration: int = -1, ax: Axes | None = None
) -> Axes:
    """Draw the N–M domain of an interface that crushes, and its iterations.

    The boundary belongs to a rectangular stress block of the compressive strength on one side of a neutral axis
    parallel to ``about``, and the tensile strength on the other. For a rectangle without tensile strength it is ``|M| =
    (N b / 2) (1 − N / (f_c A))``, which is the condition itself with the uniaxial interaction. That limits bending
    about each axis separately, so the other axis may be the one that crushes. With the biaxial interaction, and for
    joints in cells, bending about the other axis makes the domain smaller than drawn. The title therefore states the
    utilisation of crushing, and any bending about the other axis.

    Parameters
    ----------
    result
        The result of a case.
    interface
        Name of the interface.
    about
        Axis of the bending moment, ``"s"`` or ``"t"`` of the interface's frame.
    iteration
        The marked iteration; earlier ones are drawn as a path.
    ax
        Axes to draw on.

    Raises
    ------
    ModelError
        If the joint material of the interface has no compressive strength, the axis is unknown, or the case has no
        iterations.
    UnknownNameError
        If the interface or the iteration is unknown.
    """
    model = given_result(result, "crushing_domain").model
    k = chosen_interface(model, interface)
    last = chosen_iteration(result, iteration)
    if about not in ("s", "t"):
        msg = f"crushing_domain: about {about!r}; give 's' or 't', an axis of the interface"
        raise bs.errors.ModelError(msg)
    joint = model.interfaces[k]
    strength, tension = joint.joint_material.compressive_strength, joint.joint_material.tensile_strength
    if not np.isfinite(strength):
        msg = (
            f"interface {interface!r}: its joint material {joint.joint_material.name!r} has no compressive strength, "
            "so there is no crushing domain; give the JointMaterial one, or choose another interface"
        )
        raise bs.errors.ModelError(msg)

    frame = result.history["interface_frame"].to_numpy()[k]
    plane = (np.asarray(joint.polygon) - joint.centroid) @ frame[1:].T
    # A pressure p at (s, t) has the moments t p about s and −s p about t.
    plane = plane if about == "s" else plane[:, ::-1] * (1, -1)
    # The tensile strength acts on the whole area, without a moment, and both strengths together beyond the neutral
    # axis.
    N, M = stress_blocks(plane, strength + tension)
    N = N - tension * joint.area
    resultants = result.resultants.isel(interface=k)
    force = resultants["force"].sel(component="n").to_numpy()[: last + 1]
    moment = resultants["moment"].sel(component=about).to_numpy()[: last + 1]

    ax = new_axes(ax)
    n_factor, n_unit = readable(N, "N")
    m_factor, m_unit = readable(M, "N·m")
    ax.fill(N * n_factor, M * m_factor, facecolor="0.95", edgecolor="0.35", lw=1)
    ax.plot(force * n_factor, moment * m_factor, ".-", color=ACCENT, lw=0.8, ms=4, label="iterations")
    ax.plot(force[-1] * n_factor, moment[-1] * m_factor, "D", color=FORCE, ms=6, label=f"iteration {last}")
    ax.margins(0.08)
    ax.set(xlabel=f"N [{n_unit}]", ylabel=f"M about {about} [{m_unit}]")
    ax.set_title(_title(result, k, last, "t" if about == "s" else "s"), fontsize="small", loc="left")
    # The domain has points at both ends, so its corners are free.
    ax.legend(frameon=False, fontsize="small", loc="upper left")
    return ax


def _title(result: bs.CaseResult, k: int, iteration: int, other: str) -> str:
    """Return the utilisation of the interface, and its bending about the other axis.

    Bending is left out if its eccentricity is below a thousandth of the square root of the area.
    """
    history = result.history.isel(iteration=[iteration])
    name = verbatim(str(history["interface"].to_numpy()[k]))
    used = float(bs.results.utilisation(history)["crushing"].isel(iteration=0, interface=k))
    if math.isnan(used):
        return f"{name}\nnot pressed"
    lines = [name, f"utilisation of crushing {used:.2f}"]
    last = bs.results.interface_resultants(history).isel(iteration=0, interface=k)
    force, moment = float(last["force"].sel(component="n")), abs(float(last["moment"].sel(component=other)))
    if moment / force > 1e-3 * math.sqrt(float(history["interface_area"].to_numpy()[k])):
        factor, unit = readable(moment, "N·m")
        points = history["interface_of_contact_point"].to_numpy() == k
        in_cells = np.isfinite(history["cell_strength"].to_numpy()[points]).all()
        reduced = in_cells or result.settings.crushing_interaction == "biaxial"
        lines.append(f"{moment * factor:.3g} {unit} about {other}" + (" reduces the domain" if reduced else ""))
    return "\n".join(lines)


def stress_blocks(polygon: Array, strength: float) -> tuple[Array, Array]:
    """Return normal forces and moments of stress blocks, around the domain.

    Parameters
    ----------
    polygon : (k, 2) array
        Corners about the centroid, m; the moment is the force times their second coordinate.
    strength
        Pa.
    """
    area, static = bs.results.parts_beyond(polygon, np.array([0.0, 1.0]), np.linspace(1, 0, _CUTS))
    # From the whole interface to its upper edge, and back along the lower one.
    rest_area, rest_static = area[0] - area, static[0] - static
    return strength * np.concatenate([area, rest_area]), strength * np.concatenate([static, rest_static])
