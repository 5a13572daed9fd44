"""Run the command by ``python -m blockstruct``."""

from blockstruct.cli import main

main()
