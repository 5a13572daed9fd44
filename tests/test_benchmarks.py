"""The benchmarks run, on something small: their figures are for quiet machines, not for tests."""

import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "words", "said"),
    [
        ("wall_40x60", "--columns 3 --rows 3 --naive 1", "everything around the solver"),
        ("views", "--columns 3 --rows 4 --iterations 2", "paraview"),
        ("loading_path", "--walls 2x3,3x4 --without others", "over the walls"),
        ("pushover", "--walls 2x3 --steps 4", "iterations"),
        ("storage", "--columns 4 --rows 4 --programs 4 --files 2 --cases 4", "one contact force of one iteration"),
        ("surroundings", "--domes 2x4 --large 3x3 --runs 2 --sample 2", "on 2 workers"),
    ],
)
def test_benchmarks_run(name, words, said):
    command = [sys.executable, BENCHMARKS / f"{name}.py", *words.split()]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert said in run.stdout
