"""Trials of an attack: each ends with an answer or with an error of ours, within five seconds and 4 GB."""

import resource
import signal
import warnings
from collections.abc import Callable, Iterable
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import blockstruct as bs

#: Seconds and bytes that a trial may take.
SECONDS, MEMORY = 5, 4 << 30
#: Characters of the longest message.
MESSAGE = 100_000


class HangError(BaseException):
    """A trial that did not end in time; no ``except Exception`` holds it up."""


@contextmanager
def bounded(seconds=SECONDS):
    """Context that ends after some seconds, and in which memory is short."""

    def stop(number, frame):
        raise HangError

    before = signal.signal(signal.SIGALRM, stop)
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    used = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, hard))
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def outcome(trial: Callable[[], Any], seconds: float = SECONDS) -> tuple[str, str]:
    """How a trial ended, and what it said: ``answered``, ``refused``, or what must not happen."""
    try:
        with bounded(seconds), warnings.catch_warnings():
            warnings.simplefilter("ignore", bs.errors.UnusualValueWarning)
            return "answered", repr(trial())[:80]
    except HangError:
        return "hang", ""
    except AssertionError as error:
        return "wrong", str(error)
    except bs.errors.BlockstructError as error:
        said = str(error)
        return ("refused", said) if len(said) <= MESSAGE else ("long message", said)
    except BaseException as error:  # whatever else comes out is what the attack looks for
        return "raw", f"{type(error).__name__}: {error}"[:400]


def attack(trials: Iterable[tuple[str, Callable[[], Any]]]) -> dict[str, str]:
    """How each trial ended, by its name; prints those that must not end so."""
    found = {}
    for name, trial in trials:
        found[name], said = outcome(trial)
        if found[name] not in ("answered", "refused"):
            print(f"{name}: {found[name]} {said}")
    return found
