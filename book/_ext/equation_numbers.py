"""Number the paper's equations as the paper does.

A label ``eq-14`` is shown as (14) wherever it stands in the book, ``eq-4.1`` as (4.1). Any other
label is numbered within its page: (N.1) in ``book/notation``.
"""

import re
from pathlib import PurePosixPath
from typing import Any

from sphinx.application import Sphinx
from sphinx.domains.math import MathDomain


class PaperMathDomain(MathDomain):
    """The math domain with the numbers of the paper."""

    def note_equation(self, docname: str, labelid: str, location: Any = None) -> None:
        """Store the number of an equation: the paper's, or the next one of the page."""
        super().note_equation(docname, labelid, location)
        equations: dict[str, tuple[str, Any]] = self.equations
        if paper := re.fullmatch(r"eq-([\d.]+[a-z]?)", labelid):
            number = paper[1]
        else:
            before = sum(where == docname for where, _ in equations.values())
            number = f"{PurePosixPath(docname).name[0].upper()}.{before + 1}"
        equations[labelid] = (docname, number)


def without_thebe(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: Any
):
    """Leave out the scripts of live code, which this book has not: the theme adds them twice."""
    scripts = context.get("script_files", [])
    context["script_files"] = [
        script
        for script in scripts
        if "thebe" not in f"{script.attributes} {script.filename}".lower()
    ]


def setup(app: Sphinx) -> dict[str, Any]:
    """Replace Sphinx's math domain, and look after the scripts of a page."""
    app.add_domain(PaperMathDomain, override=True)
    app.connect("html-page-context", without_thebe, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
