"""The console command ``blockstruct``."""

from blockstruct.cli import runs, results, verification, documents  # isort: skip (the order of the help)
from blockstruct.cli.app import main

__all__ = ["documents", "main", "results", "runs", "verification"]
