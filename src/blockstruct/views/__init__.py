"""Tables, figures, pages and reports. This room uses the public API, and nothing in the core imports it.

Tables and texts for the console are here; :mod:`~blockstruct.views.figures`, :mod:`~blockstruct.views.page`,
:mod:`~blockstruct.views.paraview` (extra ``viz``) and :mod:`~blockstruct.views.report` (extra ``report``) are imported
by their own names.

>>> import blockstruct as bs
>>> tuff, dry = bs.Material("tuff", "12 kN/m^3"), bs.JointMaterial("dry", 0.65)
>>> blocks = bs.courses([[1]], unit_length="0.4 m", unit_height="0.8 m", thickness="1 m", material=tuff)
>>> model = bs.Model("block", blocks, bs.detect_interfaces(blocks, joint_material=dry))
>>> push = bs.LoadPattern("push", [bs.BodyForce((1, 0, 0))])
>>> case = bs.LimitCase("rocking", bs.LoadPattern("dead", [bs.SelfWeight()]), push, "associative")
>>> analysis = bs.AnalysisManager(model).run([case])
>>> print(result_text(analysis["rocking"]).plain.splitlines()[3])
  collapses at load factor 0.5 with associative flow (certified; a bound of every other flow rule)
"""

from blockstruct.views.console import (
    analysis_summary,
    archive_table,
    directions_text,
    following,
    iteration_table,
    model_text,
    parameter_texts,
    result_text,
    study_following,
    study_summary,
    study_table,
    summary_table,
)

__all__ = ["analysis_summary", "archive_table", "directions_text", "following", "iteration_table", "model_text"]
__all__ += ["parameter_texts", "result_text", "study_following", "study_summary", "study_table", "summary_table"]
