"""Least thickness of a semicircular arch under its own weight.

G. Cocchetti, E. Rizzi (2020), "Analytical and numerical analysis on the collapse modes of least-thickness circular
masonry arches at decreasing friction", Frattura ed Integrità Strutturale 51: 356–375. A continuous arch of centreline
radius r needs t/r = 0.107426 where friction does not matter (μ > 0.395832). The reference puts the weight on the
centreline; blocks have it at their own centroids, which raises the limit to 0.107478 (M. Milankovitch 1907): fine
arches are compared within 0.1 %, which holds both.

Arches of 27 straight-sided voussoirs with their corners on the two circles stand and fall within 0.4 %, at thicknesses
bracketed by an independent program in the plane: 0.10672 for μ ≥ 0.396 and 0.15118 for μ = 0.35.
"""

import math

import pytest

import blockstruct as bs
from structures import push, semicircle, solve


def arch_status(thickness, friction, voussoirs):
    return solve(semicircle(thickness, bs.JointMaterial("joint", friction), voussoirs), push(1, 0, 0)).status


@pytest.mark.parametrize(
    ("friction", "stands", "falls"), [(0.6, 0.1069, 0.1065), (0.4, 0.1069, 0.1065), (0.35, 0.1514, 0.1510)]
)
def test_27_voussoirs(friction, stands, falls):
    assert arch_status(stands, friction, 27) == "converged"
    assert arch_status(falls, friction, 27) == "unstable_under_dead_load"


@pytest.mark.parametrize(("voussoirs", "friction"), [(101, 0.6), (151, 0.6), (101, math.inf)])
def test_fine_arches_approach_the_continuous_one(voussoirs, friction):
    assert arch_status(0.107426 * 1.001, friction, voussoirs) == "converged"
    assert arch_status(0.107426 * 0.999, friction, voussoirs) == "unstable_under_dead_load"


def test_coarse_arches_need_less():
    # Fewer joints, fewer places for hinges.
    assert arch_status(0.1035, 0.6, 9) == arch_status(0.1065, 0.6, 15) == "converged"
    assert arch_status(0.1035, 0.6, 15) == arch_status(0.1065, 0.6, 27) == "unstable_under_dead_load"
