"""Structures that tests study: functions of named parameters, to be sent to other processes."""

import os
import signal
import time
from pathlib import Path

import numpy as np
import xarray as xr

import blockstruct as bs
from blockstruct import Q_
from structures import SELF_WEIGHT, STONE, bonded, box, model_of, push


def block(friction_coefficient, height="1 m"):
    """A block 0.5 m wide: it slides at μ or rocks at b / h."""
    ground = box("ground", [-1, -1, -0.5], [2.5, 3, 0.5], fixed=True)
    free = bs.Block.box("block", Q_([0, 0, 0], "m"), [Q_(0.5, "m"), Q_(1, "m"), height], STONE)
    model = model_of([ground, free], bs.JointMaterial("joint", friction_coefficient))
    return model, bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0), "associative")


def pulled(friction_coefficient):
    """A block tied to a support beside it: a push, and the support that moves away."""
    model, case = block(friction_coefficient)
    pier = box("pier", [-0.9, 0, 0], [0.5, 1, 1], fixed=True)
    tie = bs.Tie("tie", ("pier", "[-0.4, 0.5, 0.1] m"), ("block", "[0, 0.5, 0.1] m"), yield_force="50 kN")
    tied = bs.Model("tied", [*model.blocks, pier], model.interfaces, ties=[tie])
    return tied, [case, bs.SettlementCase("spreads", SELF_WEIGHT, ["pier"], "-x")]


def wall(friction_coefficient):
    """Six units pushed without dilatancy and pressed down without end, and their base that sinks."""
    model = model_of(bonded(2, 3), bs.JointMaterial("joint", friction_coefficient))
    down = bs.LoadPattern("press", [bs.BodyForce((0, 0, -1))])
    cases = [bs.LimitCase(load.name, SELF_WEIGHT, load) for load in (push(1, 0, 0), down)]
    return model, [*cases, bs.SettlementCase("sinks", SELF_WEIGHT, ["base"], "-z")]


def failing(friction_coefficient, height="1 m"):
    """A block whose model cannot be built at one value."""
    if friction_coefficient == 0.4:
        msg = "no such stone"
        raise ValueError(msg)
    return block(friction_coefficient, height)


def killing(friction_coefficient, folder):
    """A block whose worker is killed once, at one value."""
    if friction_coefficient == 0.4:
        once(folder)
    return block(friction_coefficient)


def dying(friction_coefficient):
    """A block whose worker is killed every time, at one value."""
    if friction_coefficient == 0.4:
        os.kill(os.getpid(), signal.SIGKILL)
    return block(friction_coefficient)


def samples(alpha, status=None):
    """Study of given load factors, as if they had been run."""
    alpha = np.asarray(alpha, dtype=float)
    status = ["converged"] * len(alpha) if status is None else status
    data = {"load_factor": (("run", "case"), alpha[:, None]), "status": (("run", "case"), np.array(status)[:, None])}
    return xr.Dataset(data, coords={"case": ["push"]}, attrs={"sampling": "monte carlo"})


def slow(friction_coefficient, folder):
    """A block that waits for a file after it has said that it is at work."""
    if friction_coefficient == 0.4 and not Path(folder, "killed").exists():
        Path(folder, "worker").write_text(str(os.getpid()))
        time.sleep(30)
    return block(friction_coefficient)


def once(folder):
    """Kill this process, the first time."""
    mark = Path(folder, "killed")
    if not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
