"""Tables, figures, pages and reports. This room uses the public API, and nothing in the core imports it.

Tables and texts for a terminal are in :mod:`~blockstruct.views.console`. :mod:`~blockstruct.views.figures`,
:mod:`~blockstruct.views.page` and :mod:`~blockstruct.views.paraview` need the extra ``viz``,
:mod:`~blockstruct.views.report` needs the extra ``report``.

>>> import blockstruct as bs
>>> from blockstruct.views.console import result_text
>>> tuff, dry = bs.Material("tuff", "12 kN/m^3"), bs.JointMaterial("dry", 0.65)
>>> blocks = bs.courses([[1]], unit_length="0.4 m", unit_height="0.8 m", thickness="1 m", material=tuff)
>>> model = bs.Model("block", blocks, bs.detect_interfaces(blocks, joint_material=dry))
>>> push = bs.LoadPattern("push", [bs.BodyForce((1, 0, 0))])
>>> case = bs.LimitCase("rocking", bs.LoadPattern("dead", [bs.SelfWeight()]), push, "associative")
>>> analysis = bs.AnalysisManager(model).run([case])
>>> print(result_text(analysis["rocking"]).plain.splitlines()[3])
  collapses at load factor 0.5 with associative flow (certified; a bound of every other flow rule)
"""
