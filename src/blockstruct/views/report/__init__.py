"""The report of an analysis, as one HTML file that prints, or as PDF.

Needs ``pip install "blockstruct[report]"``, or ``"blockstruct[pdf]"``.
"""

import blockstruct as bs

try:
    import jinja2  # noqa: F401 - the report is a template
    import matplotlib  # noqa: F401 - with figures
except ModuleNotFoundError as error:
    missing = bs.errors.MissingExtraError.of(error, "report", "report")
    missing.add_note('a report as PDF needs more, all of which comes with: pip install "blockstruct[pdf]"')
    raise missing from error

from blockstruct.views.report.html import report_html, write_report

__all__ = ["report_html", "write_report"]
