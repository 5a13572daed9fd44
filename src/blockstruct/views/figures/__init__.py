"""Figures with matplotlib, for papers and reports. Needs ``pip install "blockstruct[viz]"``.

Every function takes an Axes (or makes one) and returns it, so that figures combine and ``ax.figure.savefig`` works:

>>> import matplotlib
>>> matplotlib.use("Agg")
>>> import blockstruct as bs
>>> from blockstruct.views import figures
>>> tuff, dry = bs.Material("tuff", "12 kN/m^3"), bs.JointMaterial("dry", 0.65)
>>> blocks = bs.courses([[1]], unit_length="0.4 m", unit_height="0.8 m", thickness="1 m", material=tuff)
>>> model = bs.Model("block", blocks, bs.detect_interfaces(blocks, joint_material=dry))
>>> push = bs.LoadPattern("push", [bs.BodyForce((1, 0, 0))])
>>> case = bs.LimitCase("rocking", bs.LoadPattern("dead", [bs.SelfWeight()]), push, "associative")
>>> result = bs.AnalysisManager(model).run([case])["rocking"]
>>> ax = figures.mechanism(result, amplitude="10 cm", look="y")
>>> ax.get_xlabel(), ax.get_ylabel()
('x [m]', 'z [m]')
"""

import blockstruct as bs

try:
    import matplotlib  # noqa: F401 - the figures below need it
except ModuleNotFoundError as error:
    raise bs.errors.MissingExtraError.of(error, "viz", "figures") from error

from blockstruct.views.figures.diagrams import (
    capacity,
    certificate,
    convergence,
    crushing_domain,
    response,
    verification,
)
from blockstruct.views.figures.sheet import drawings, overview, write_figures
from blockstruct.views.figures.structure import dimensions, forces, loads, mechanism, structure
from blockstruct.views.figures.studies import compass, curve, distribution, fragility, tornado

__all__ = ["dimensions", "forces", "loads", "mechanism", "structure"]
__all__ += ["capacity", "certificate", "convergence", "crushing_domain", "curve", "response", "verification"]
__all__ += ["compass", "distribution", "fragility", "tornado"]
__all__ += ["drawings", "overview", "write_figures"]
