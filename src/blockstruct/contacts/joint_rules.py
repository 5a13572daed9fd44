"""Rules that assign joint materials to joints."""

import re
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any

from blockstruct.errors import ModelError, shown
from blockstruct.model import Interface, JointMaterial
from blockstruct.vocabulary import JointOrientation

Rule = Callable[[Interface], JointMaterial]


@cache
def unruled() -> JointMaterial:
    """Return a placeholder for the joint material that a rule assigns later."""
    return JointMaterial("without a rule", 0.0)


def joint_rule(material: Any, who: str) -> Rule:
    """Return a function from an interface to its joint material.

    Parameters
    ----------
    material
        A joint material for all joints; a function from an interface to its joint material; or a mapping from patterns
        to joint materials, whose first match counts. Patterns are ``"bed"``, ``"head"`` or ``"inclined"``
        (:class:`blockstruct.vocabulary.JointOrientation`), the names of two blocks in any order with ``*`` for any
        text, such as ``"base|*"``, and ``"*"`` for all other joints.
    who
        Name of the caller in error messages.

    Raises
    ------
    ModelError
        If the argument is of another kind, or, when the rule is applied, if no pattern fits a joint.

    Examples
    --------
    >>> from blockstruct.model import JointMaterial
    >>> lime, dry = JointMaterial("lime", 0.7), JointMaterial("dry", 0.6)
    >>> rule = joint_rule({"base|*": dry, "bed": lime, "*": dry}, "wall")
    >>> square = "m", [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> from blockstruct.units import Q_
    >>> polygon = Q_(square[1], square[0])
    >>> [rule(Interface("i", "1.1", plus, polygon, dry)).name for plus in ("2.1", "base")]
    ['lime', 'dry']
    """
    if isinstance(material, JointMaterial):
        return lambda interface: material
    if isinstance(material, Mapping) and material:
        for pattern, one in material.items():
            _check_pattern(pattern, one, who)
        return lambda interface: _first_match(material, interface, who)
    if callable(material) and not isinstance(material, type):
        return lambda interface: _call_rule(material, interface, who)
    msg = (
        f"{who}: joint_material is {shown(material)}; give a JointMaterial, a mapping such as "
        "{'bed': mortar, '*': dry}, or a function from an interface to its JointMaterial"
    )
    raise ModelError(msg)


def _check_pattern(pattern: Any, material: Any, who: str) -> None:
    if not isinstance(pattern, str) or not (pattern in {*JointOrientation, "*"} or pattern.count("|") == 1):
        msg = (
            f"{who}: {shown(pattern)} is not a pattern of joints; write "
            f"{', '.join(repr(o.value) for o in JointOrientation)}, two block names as in 'base|*', "
            "or '*' for all other joints"
        )
        raise ModelError(msg)
    if not isinstance(material, JointMaterial):
        msg = f"{who}: the pattern {shown(pattern)} gives {shown(material)}; give a JointMaterial"
        raise ModelError(msg)


def _first_match(rules: Mapping[str, JointMaterial], interface: Interface, who: str) -> JointMaterial:
    for pattern, material in rules.items():
        if pattern == interface.orientation or _names_fit(pattern, interface):
            return material
    msg = (
        f"{who}: no pattern of joint_material fits interface {interface.name!r} ({interface.orientation}); "
        f"the patterns are {', '.join(map(repr, rules))}; add '*' for all other joints"
    )
    raise ModelError(msg)


def _names_fit(pattern: str, interface: Interface) -> bool:
    # Only * is special: names may contain any other character.
    wanted = re.compile(".*".join(map(re.escape, pattern.split("*"))), re.DOTALL)
    ends = (interface.minus, interface.plus)
    return any(wanted.fullmatch("|".join(names)) for names in (ends, ends[::-1]))


def check_rules_fit(material: Any, interfaces: Iterable[Interface], who: str) -> None:
    """Refuse patterns of block names without a match: with a misspelt name, another pattern would apply.

    Raises
    ------
    ModelError
        If the mapping has such a pattern.
    """
    interfaces = list(interfaces)
    if not isinstance(material, Mapping) or not interfaces:
        return
    for pattern in material:
        if "|" in pattern and not any(_names_fit(pattern, i) for i in interfaces):
            msg = (
                f"{who}: no interface fits the pattern {shown(pattern)} of joint_material; correct its names (as in "
                f"{interfaces[0].name!r}) or remove it"
            )
            raise ModelError(msg)


def _call_rule(function: Callable[[Interface], Any], interface: Interface, who: str) -> JointMaterial:
    material = function(interface)
    if not isinstance(material, JointMaterial):
        result = f"{shown(material)} for {interface.name!r}"
        msg = f"{who}: the function for joint_material returns {result}; return a JointMaterial"
        raise ModelError(msg)
    return material
