"""MyST for the book, from the plain Markdown that a notebook has.

JupyterLab shows links, formulas and tables, but no roles. A notebook therefore has links alone, and
the page gets from them what a book needs:

==============================================  ==================================================
notebook                                        page
==============================================  ==================================================
``$$ … \\tag{8}$$``                              a numbered equation, to refer to and to search for
``[Eq. 8](05_simulation.ipynb#eq-8)``           a reference to it, with a preview
``[erratum 6](22_errata.ipynb#erratum-6)``      a reference to its heading, ``### 6 · …``
``[Kay 1993](../book/references.bib#kay1993)``  a citation
==============================================  ==================================================

Every other link stays as it is.
"""

import re

EQUATION = re.compile(r"\$\$((?:(?!\$\$).)*?)\s*\\tag\{([^}]+)\}\s*\$\$", re.DOTALL)
TO_EQUATION = re.compile(r"\[(Eqs?\.\s)?[\d.]+\w?\]\((?:\w+\.ipynb)?#(eq-[\w.]+)\)")
TO_ERRATUM = re.compile(r"\[([^\]]+)\]\((?:22_errata\.ipynb)?#(erratum-\d+)\)")
ERRATUM = re.compile(r"^### (\d+) · ", re.M)
TO_SOURCE = re.compile(r"\[[^\]]+\]\(\.\./book/references\.bib#(\w+)\)")
PERCENT = re.compile(r"\n(?=%)")


def myst(text: str) -> str:
    """Return the text of a page from that of a notebook's cell."""
    text = PERCENT.sub(
        "\u00a0", text
    )  # at the start of a line it would begin a comment
    text = EQUATION.sub(r"```{index} ! Eq. \2\n```\n$$\1\n$$ (eq-\2)", text)
    text = TO_EQUATION.sub(r"\1{eq}`\2`", text)
    text = TO_ERRATUM.sub(r"{ref}`\1 <\2>`", text)
    text = ERRATUM.sub(r"(erratum-\1)=\n\g<0>", text)
    return TO_SOURCE.sub(r"{cite:t}`\1`", text)
