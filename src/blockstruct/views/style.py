"""Colours and units of all views. Colour-blind readers and grey printers can distinguish the colours."""

import blockstruct as bs

#: Colour of each contact state and of joints at rest, from the palette of Okabe & Ito (2008).
STATE_COLOURS = {
    bs.vocabulary.ContactState.CRUSHING.value: "#000000",
    bs.vocabulary.ContactState.SLIDING.value: "#d55e00",
    bs.vocabulary.ContactState.TWISTING.value: "#cc79a7",
    bs.vocabulary.ContactState.HINGE.value: "#0072b2",
    bs.vocabulary.ContactState.OPEN.value: "#56b4e9",
    bs.vocabulary.ContactState.STICKING.value: "#b5ada1",
    bs.vocabulary.ContactState.UNKNOWN.value: "#f0e442",
}
STONE, SUPPORT, EDGE, GHOST = "#ede8df", "#c9c1b4", "#8d8578", "#d8d3ca"
FORCE, ACCENT = "#d55e00", "#0072b2"
#: Colours of named curves on one Axes, without the colour of marked points, from the same palette.
CURVES = (ACCENT, "#009e73", "#cc79a7", "#000000")
#: Colours of ties: of a model, and by their state.
TIE = "#00664d"
TIE_COLOURS = {
    bs.ties.TieState.SLACK.value: "#9fb8b0",
    bs.ties.TieState.STRESSED.value: TIE,
    bs.ties.TieState.YIELDING.value: "#e69f00",
    bs.ties.TieState.PUNCHING.value: "#882255",
    bs.ties.TieState.SLIPPING.value: "#cc79a7",
    bs.ties.TieState.BROKEN.value: "#cccccc",
    bs.ties.TieState.UNKNOWN.value: "#f0e442",
}
#: Blocks under other drawings.
PALE_STONE, PALE_EDGE = "#f7f4ef", "#cfc8bd"
#: Colours of a utilisation from 0 to 1.
UTILISATION = ("#d8d3ca", "#56a3d0", "#003a5c")
#: Colours of a displacement from zero to the largest: stone that becomes darker.
DISPLACEMENT = (STONE, "#8fc1de", "#2f86c1", "#0a4f86")
#: Colours of the moving macro-blocks, in turn: palette of Okabe & Ito (2008), light enough for edges to show.
BODY_COLOURS = ("#56b4e9", "#e69f00", "#4dbd95", "#d79ac0", "#f0e442", "#7f9fd4", "#e2865a", "#a3a3a3")
#: Way of the corner that moves farthest, and longest arrow, relative to the largest extent of the structure.
AMPLITUDE, ARROW = 0.1, 0.16
#: Width of the lines of joints and ties, points.
LINE = 2.0
#: Measures of a certificate, and their lines.
MEASURES = {
    "equilibrium_residual": ("equilibrium residual", "#0072b2", "o"),
    "yield_excess": ("yield excess", "#d55e00", "s"),
    "interpenetration": ("interpenetration", "#009e73", "^"),
    "flow_rule_gap": ("flow-rule gap", "#000000", "D"),
}


def parts(state: str) -> list[str]:
    """Return the states in a text such as ``"hinge + sliding"``, in the order of :data:`STATE_COLOURS`.

    >>> parts("hinge + sliding")
    ['sliding', 'hinge']
    """
    return sorted(state.split(" + "), key=list(STATE_COLOURS).index)
