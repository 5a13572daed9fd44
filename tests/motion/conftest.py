"""Whatever a procedure finds must stand the checks of a file."""

from confirmed import confirmed  # noqa: F401 - for every test of this folder
