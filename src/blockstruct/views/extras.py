"""Packages that views need and the core does not."""

import blockstruct as bs


def missing(error: ModuleNotFoundError, extra: str) -> bs.MissingExtraError:
    """Error that tells how to install the package that was not found."""
    msg = f'{error.name} is not installed; it comes with: pip install "blockstruct[{extra}]"'
    return bs.MissingExtraError(msg, name=error.name)
