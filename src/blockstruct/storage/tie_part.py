"""The ties of a model as variables of a Dataset, and back."""

from typing import Any

import numpy as np
import xarray as xr

from blockstruct.model import TIE_KINDS, TIE_QUANTITIES, AnyTie, Model, given_quantities, tie_kind_of
from blockstruct.units import SI_UNITS, to_quantity


def tie_variables(model: Model) -> dict[str, Any]:
    """Variables of the ties of a model, none without ties."""
    ties = model.ties
    if not ties:
        return {}
    index = {b.name: i for i, b in enumerate(model.blocks)}
    anchored = [TIE_KINDS[tie_kind_of(tie)].anchored for tie in ties]
    ends: list[Any] = [
        (t.start, t.end) if a else (("", t.start), ("", t.end)) for t, a in zip(ties, anchored, strict=True)
    ]
    blocks = [[index.get(block, -1) for block, _ in both] for both in ends]
    points = np.array([[point for _, point in both] for both in ends], dtype=float)
    values = [given_quantities(tie) for tie in ties]
    return {
        "tie": ("tie", np.array([tie.name for tie in ties], dtype=object)),
        "kind_of_tie": ("tie", np.array([tie_kind_of(tie) for tie in ties], dtype=object)),
        "block_of_tie": (("tie", "tie_end"), np.array(blocks, dtype=np.int64)),
        "end_of_tie": (("tie", "tie_end", "axis"), points, {"units": SI_UNITS["length"]}),
        **{
            f"{name}_of_tie": ("tie", [own.get(name, np.nan) for own in values], {"units": SI_UNITS[dimension]})
            for name, dimension in TIE_QUANTITIES.items()
        },
    }


def ties_of(ds: xr.Dataset) -> list[AnyTie]:
    """Ties of a Dataset, built through the same constructors and checks as any other."""
    return [_tie(ds.isel(tie=k)) for k in range(ds.sizes.get("tie", 0))]


def _tie(one: xr.Dataset) -> AnyTie:
    kind = TIE_KINDS[str(one["kind_of_tie"].item())]
    points = [to_quantity(point, "length") for point in one["end_of_tie"].to_numpy()]
    blocks = [str(one["block"].to_numpy()[b]) if b >= 0 else "" for b in one["block_of_tie"].to_numpy()]
    start, end = zip(blocks, points, strict=True) if kind.anchored else points
    given = {name: float(one[f"{name}_of_tie"]) for name in kind.quantities}
    quantities = {n: to_quantity(v, TIE_QUANTITIES[n]) for n, v in given.items() if not np.isnan(v)}
    return kind.type(str(one["tie"].item()), start, end, **quantities)
