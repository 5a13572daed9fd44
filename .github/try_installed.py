"""Try an installed blockstruct as a user would: demo, run twice, show, report, validate, a study on two processes.

Run it in an empty folder, far from the source: ``python try_installed.py EXAMPLES``.
"""

import shutil
import subprocess
import sys
from pathlib import Path


def blockstruct(*words: str) -> None:
    """Run a command, and stop at a failure."""
    print("$ blockstruct", *words, flush=True)
    subprocess.run([shutil.which("blockstruct") or "blockstruct", *words], check=True)


def main() -> None:
    """Run the commands."""
    examples = Path(sys.argv[1]).resolve()
    blockstruct("--version")
    blockstruct("demo", "--output", "demo.h5")
    for _ in range(2):  # The second run replaces the file of the first.
        blockstruct("run", str(examples / "ferris_tin_loi_wall_1.yaml"), "--output", "wall.h5")
    blockstruct("validate", "wall.h5")
    blockstruct("show", "wall.h5")
    blockstruct("report", "wall.h5", "--output", "wall.html")
    blockstruct("study", str(examples / "friction_study.yaml"), "--output", "runs", "--workers", "2")
    blockstruct("archive", "runs")
    if left := sorted(map(str, Path().rglob("*.partial"))):
        sys.exit(f"working data left behind: {left}")
    size = Path("wall.html").stat().st_size
    print(f"wall.html: {size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
