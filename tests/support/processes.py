"""Trials in processes of their own: one that hangs or crashes is counted, and the next begins."""

import collections
import multiprocessing
import time

#: Seconds of a processor that a trial may take, and of silence after which it is taken to hang.
LIMIT, PATIENCE = 5.0, 60.0
FRESH = multiprocessing.get_context("forkserver")
# The package imports its rooms when they are asked for; what stands beside it is not found where processes begin.
FRESH.set_forkserver_preload(["blockstruct.analysis", "blockstruct.contacts", "jsonschema", "pytest"])


def count(trial, seeds, *words):
    """Outcomes of ``trial(seed, *words)``, each a text; a process that ends by itself or takes too long is one, too."""
    outcomes, left = collections.Counter(), list(seeds)
    while left:
        here, there = FRESH.Pipe(duplex=False)
        process = FRESH.Process(target=_work, args=(there, trial, left, words))
        process.start()
        there.close()
        outcome = _listen(here, left, outcomes)
        process.kill()
        process.join()
        if outcome:
            outcomes[outcome] += 1
            print(f"{trial.__name__} {left.pop(0)}: {outcome}")
    return outcomes


def _listen(pipe, left, outcomes):
    """Take what a process tells; what has become of it, if that is not all."""
    while left:
        if not pipe.poll(PATIENCE):
            return "hang"
        try:
            told = pipe.recv()
        except EOFError:
            return "crash"
        if told is not None:
            outcome, seconds = told
            outcomes[outcome if seconds < LIMIT else "slow"] += 1
            left.pop(0)
    return ""


def _work(pipe, trial, seeds, words):
    pipe.send(None)
    for seed in seeds:
        start = time.process_time()
        outcome = trial(seed, *words)
        pipe.send((outcome, time.process_time() - start))
