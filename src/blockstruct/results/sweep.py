"""Results of one case along a property of its joints."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from blockstruct.results.case_result import CaseResult
from blockstruct.units import SI_UNITS


def sweep_of(quantity: str, dimension: str, values: Sequence[float], results: Sequence[CaseResult]) -> xr.Dataset:
    """Dataset of the load factors of one case along a quantity.

    Parameters
    ----------
    quantity, dimension
        Name of the quantity, and its dimension, a key of ``units.SI_UNITS``.
    values
        Its values, SI.
    results
        Result at each value.
    """
    number = {"units": SI_UNITS["dimensionless"]}
    gaps = [np.nan if r.certificate is None else r.certificate.flow_rule_gap for r in results]
    return xr.Dataset(
        {
            "load_factor": (quantity, [r.load_factor for r in results], number | {"long_name": "load factor α"}),
            "status": (quantity, np.array([r.status.value for r in results], dtype=object)),
            "flow_rule_gap": (quantity, gaps, number | {"long_name": "flow-rule gap of the certificate"}),
            "n_iterations": (quantity, [r.n_iterations for r in results], number | {"long_name": "programs"}),
        },
        coords={quantity: (quantity, np.array(values), {"units": SI_UNITS[dimension]})},
        attrs={"case": results[0].name if results else ""},
    )
