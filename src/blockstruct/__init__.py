"""Find the collapse load of masonry structures by rigid-block limit analysis in 3D.

Define a structure:

>>> import blockstruct as bs
>>> from blockstruct import Q_
>>> tuff = bs.Material("tuff", unit_weight=Q_(12, "kN/m^3"))
>>> lime = bs.JointMaterial("lime mortar", friction_coefficient=0.65)
>>> rows = [[1, 1], [0.5, 1, 0.5], [1, 1], [0.5, 1, 0.5]]
>>> blocks = bs.courses(
...     rows, unit_length=Q_(40, "cm"), unit_height=Q_(17.5, "cm"), thickness=Q_(10, "cm"), material=tuff
... )
>>> found = bs.detect_interfaces(blocks, joint_material=lime)
>>> model = bs.Model("small wall", blocks, found)

Find its collapse load:

>>> dead = bs.LoadPattern("dead", [bs.SelfWeight()])
>>> push = bs.LoadPattern("push +y", [bs.BodyForce(direction=(0, 1, 0))])
>>> case = bs.LimitCase("out of plane", dead=dead, variable=push, flow="nonassociative")
>>> analysis = bs.run(model, [case])
>>> result = analysis["out of plane"]
>>> print(result.status, round(result.load_factor, 4))
converged 0.1429

Look at every iteration:

>>> sorted(result.history.sizes)
['axis', 'block', 'component', 'contact_point', 'interface', 'interface_corner', 'iteration']
>>> result.certificate.holds
True
"""

import ast
from importlib import import_module
from pathlib import Path
from typing import Any

__version__ = "0.1.0"

#: Modules of the public names, from the stub that lists the names for type checkers. A name is imported at its first
#: use, which keeps the import light.
_MODULES = {
    name.name: node.module
    for node in ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")).body
    if isinstance(node, ast.ImportFrom)
    for name in node.names
}
__all__ = list(_MODULES)


def __getattr__(name: str) -> Any:
    module = _MODULES.get(name, __name__)
    if module != __name__:
        return getattr(import_module(module), name)
    try:
        return import_module(f"{__name__}.{name}")
    except ModuleNotFoundError as error:
        if error.name != f"{__name__}.{name}":
            raise
        msg = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(msg) from None


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
