"""Results of one case along properties of its joints."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct.results.case_result import CaseResult
from blockstruct.units import SI_UNITS
from blockstruct.vocabulary import Status


def sweep_of(axes: Mapping[str, tuple[Sequence[float], str]], results: Sequence[CaseResult], case: str) -> xr.Dataset:
    """Dataset of the load factors of one case along quantities.

    Parameters
    ----------
    axes
        Values and unit of each quantity.
    results
        Result at each point, the last quantity running fastest; fewer if the sweep was interrupted.
    case
        Name of the case.
    """
    number = {"units": SI_UNITS["dimensionless"]}
    shape = tuple(len(values) for values, _ in axes.values())
    gaps = [np.nan if r.certificate is None else r.certificate.flow_rule_gap for r in results]

    def along(values: Sequence[object], missing: object, kind: type) -> tuple[list[str], object]:
        filled: NDArray[Any] = np.full(int(np.prod(shape)), missing, dtype=kind)
        filled[: len(results)] = values
        return list(axes), filled.reshape(shape)

    return xr.Dataset(
        {
            "load_factor": (
                *along([r.load_factor for r in results], np.nan, float),
                number | {"long_name": "load factor α"},
            ),
            "status": along([r.status.value for r in results], Status.INTERRUPTED.value, object),
            "flow_rule_gap": (*along(gaps, np.nan, float), number | {"long_name": "flow-rule gap of the certificate"}),
            "n_iterations": (*along([r.n_iterations for r in results], 0, int), number | {"long_name": "programs"}),
        },
        coords={name: (name, np.array(values), {"units": unit}) for name, (values, unit) in axes.items()},
        attrs={"case": case},
    )
