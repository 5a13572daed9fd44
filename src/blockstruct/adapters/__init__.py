"""Adapters: problems of other programs, solved here. Each is imported by its own name.

:mod:`~blockstruct.adapters.compas_dem` needs ``pip install "blockstruct[compas]"``.
"""
