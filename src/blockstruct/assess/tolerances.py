"""Tolerances of the room, each relative to the quantity that it belongs to."""

#: Accuracy of a collapse state: a smaller share of a force, a motion, a length or a ratio counts as zero.
ACCURACY = 1e-3
#: Rounding of directions, positions and sums.
ROUNDING = 1e-6
#: Vertical part of the normal of a joint from which its upper block stands on the lower one.
STANDS = 0.5
#: Difference of the d0 of two capacity curves of one mechanism, from which they do not describe one motion.
OTHER_CURVE = 0.03
