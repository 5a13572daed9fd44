"""Limits that several checks share."""

#: Vertical part of the normal of a joint from which its upper block stands on the lower one.
STANDS = 0.5
#: Difference of the d0 of two capacity curves of one mechanism, from which they do not describe one motion.
OTHER_CURVE = 0.03
