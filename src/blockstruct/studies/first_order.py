"""First-order scatter of an associative load factor, from one run."""

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from blockstruct.analysis import AnalysisManager
from blockstruct.errors import LoadFactorWarning, ModelError, StudyWarning, UnknownNameError, shown
from blockstruct.keywords import did_you_mean
from blockstruct.model import JOINT_PROPERTIES, JointMaterial, LimitCase, Model
from blockstruct.results import CaseResult, sliding_rates
from blockstruct.units import si
from blockstruct.vocabulary import Flow, Stage, Status

_NONE = {"units": "dimensionless"}
#: Relative step of the coefficients in the test for a kink, and tolerated difference of derivatives in the test.
_STEP, _SAME = 1e-4, 0.02
#: Derivative, relative to the load factor, that counts as rounding.
_ROUNDING = 1e-6


def first_order(result: CaseResult, standard_deviation: float | Mapping[str, float]) -> xr.Dataset:
    """Return the sensitivity of the load factor to the friction of joints.

    The result includes the first-order scatter of the load factor.

    Parameters
    ----------
    result
        Result of a converged case with associative flow.
    standard_deviation
        Standard deviation of the friction coefficients: one value, or one for each joint material by name.

    Returns
    -------
    xarray.Dataset
        Along ``interface``: ``derivative``, dα/dμ_k; ``friction_coefficient``; ``joint_material``; ``contribution``,
        the derivative times the standard deviation. Joints are in order of their contributions. Without dimension:
        ``load_factor``, and its standard deviation ``independent``, for independent coefficients of all joints, and
        ``correlated``, for equal coefficients within a joint material. The attribute ``unique`` is 1 if the derivatives
        exist.

    Warns
    -----
    StudyWarning
        If the load factor has no derivatives there. Run a study of samples instead.

    Raises
    ------
    ModelError
        If the case did not converge, or is without dilatancy, in which case multipliers are not derivatives.

    Notes
    -----
    The associative load factor is the value of a convex program. Its derivative with respect to the bound of a
    condition is the multiplier of the condition [1]_. At contact point k the condition is ``‖(s, t)‖ ≤ c A + μ n``.
    Its multiplier is the sliding velocity ``‖v_t‖`` (with ``w_L·u = 1``). Hence ``dα/dμ_k = n ‖v_t‖``, summed over the
    points of a joint. If a joint has the torsion of uniform pressure, the sliding rate of its cone is added.

    These values are derivatives if mechanism and forces are unique. If several mechanisms share a load factor, the load
    factor has a kink. An example is a wall of equal joints that slides at any course. The load factor then follows the
    weakest mechanism and falls more than any derivative predicts. Two more runs detect a kink: all coefficients a
    little higher and lower, in shares drawn at random. ``unique`` gives the outcome.

    References
    ----------
    .. [1] S. Boyd, L. Vandenberghe, Convex Optimization, Cambridge University Press 2004, section 5.6.
    """
    if not isinstance(result, CaseResult):
        msg = f"first_order: {shown(result)} is not a result; give that of a case, as analysis['push']"
        raise ModelError(msg)
    if not isinstance(result.case, LimitCase):
        msg = f"first_order: case {result.name!r} is a settlement; give the result of a LimitCase"
        raise ModelError(msg)
    if result.case.flow is not Flow.ASSOCIATIVE or result.status is not Status.CONVERGED:
        msg = (
            f"first_order: case {result.name!r} has {result.case.flow} flow and {result.status.predicate}; run it with "
            "flow='associative': its load factor is an upper bound of the other, and has derivatives"
        )
        raise ModelError(msg)
    history = result.history
    last = history.isel(iteration=int(np.flatnonzero(history["stage"].to_numpy() == Stage.ASSOCIATIVE.value)[-1]))
    normal = last["contact_force"].sel(component="n").to_numpy()
    sliding = sliding_rates(result.model, last, result.settings.crushing_cells)
    of_point = history["interface_of_contact_point"].to_numpy()
    derivative = np.bincount(of_point, normal * sliding, minlength=history.sizes["interface"])
    joints = [interface.joint_material for interface in result.model.interfaces]
    names = np.array([joint.name for joint in joints], dtype=object)
    contribution = derivative * _of_joints(standard_deviation, names)
    order = np.argsort(-np.abs(contribution), kind="stable")
    sums = [contribution[names == name].sum() for name in dict.fromkeys(names)]
    along = ("interface",)
    predicted, left, right = _kink(result, derivative)
    # If friction has no effect, as in rocking, the derivatives are rounding errors.
    same = max(_SAME * float(np.abs(derivative).sum()), _ROUNDING * abs(result.load_factor))
    unique = max(abs(left - predicted), abs(right - predicted)) <= same
    if not unique:
        msg = (
            f"first_order: case {result.name!r} has no derivatives with respect to friction: several mechanisms or "
            f"force states have its load factor (together, {left:.3g} downwards and {right:.3g} upwards, where the "
            f"multipliers say {predicted:.3g}); run a study with samples of the friction of each joint instead"
        )
        warnings.warn(msg, StudyWarning, stacklevel=2)
    columns: dict[str, Any] = {
        "derivative": (along, derivative, _NONE | {"long_name": "dα/dμ"}),
        "friction_coefficient": (along, [joint.friction_coefficient for joint in joints], _NONE),
        "joint_material": (along, names),
        "contribution": (along, contribution, _NONE | {"long_name": "dα/dμ times the standard deviation of μ"}),
    }
    scalars: dict[str, Any] = {
        "load_factor": ((), result.load_factor, _NONE),
        "independent": ((), float(np.linalg.norm(contribution)), _NONE),
        "correlated": ((), float(np.linalg.norm(sums)), _NONE),
    }
    coords = {"interface": history["interface"].to_numpy()}
    table = xr.Dataset(columns, coords=coords).isel(interface=order)
    return table.assign(scalars).assign_attrs(case=result.name, unique=int(unique))


def _kink(result: CaseResult, derivative: Any) -> tuple[float, float, float]:
    """Return the derivative in one direction of all coefficients.

    Three values: by the multipliers, and one-sided downwards and upwards.
    """
    interfaces = result.model.interfaces
    mu = np.array([interface.joint_material.friction_coefficient for interface in interfaces])
    # Joints that never slide keep their coefficients.
    share = np.random.default_rng(0).uniform(0.5, 1.5, len(mu)) * np.where(np.isinf(mu), 0.0, mu)

    def load_factor(step: float) -> float:
        changed = []
        for k, interface in enumerate(interfaces):
            values = {name: getattr(interface.joint_material, name) for name in JOINT_PROPERTIES}
            # Dilatancy has no effect in associative flow, and may not exceed the friction angle.
            values |= {"friction_coefficient": mu[k] + step * share[k], "dilatancy_angle": 0.0}
            if 0 < mu[k] < np.inf:
                # Tensile strength may not exceed the tension at the apex of the friction cone.
                most = values["cohesion"] / values["friction_coefficient"]
                values["tensile_strength"] = min(values["tensile_strength"], most)
            joint = JointMaterial.from_si(f"{k}", values, torsion=interface.joint_material.torsion)
            changed.append(interface.with_joint_material(joint))
        model = Model(result.model.name, result.model.blocks, changed, ties=result.model.ties)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", LoadFactorWarning)
            manager = AnalysisManager(model, settings=result.settings, progress=False, effects=False)
            return manager.run([result.case])[result.name].load_factor

    left, right = ((load_factor(step) - result.load_factor) / step for step in (-_STEP, _STEP))
    return float(derivative @ share), left, right


def _of_joints(given: Any, names: Any) -> Any:
    """Return the standard deviation of each joint."""
    if not isinstance(given, Mapping):
        given = dict.fromkeys(names, given)
    for name in given:
        if name not in names:
            msg = f"first_order: no joint material {shown(name)}; {did_you_mean(str(name), sorted(set(names)))}"
            raise UnknownNameError(msg)
    deviations = {n: si(v, "dimensionless", f"first_order: standard deviation of {n!r}") for n, v in given.items()}
    for name, value in deviations.items():
        if value < 0:
            msg = f"first_order: standard deviation {value:g} of {name!r}; give zero or more"
            raise ModelError(msg)
    return np.array([deviations.get(name, 0.0) for name in names])
