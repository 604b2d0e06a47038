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

from cmtof_book.notes import replaced

RULES = {
    # at the start of a line it would begin a comment
    r"\n(?=%)": "\u00a0",
    # an equation with its number
    r"(?s)\$\$((?:(?!\$\$).)*?)\s*\\tag\{([^}]+)\}\s*\$\$": (
        r"```{index} ! Eq. \2\n```\n$$\1\n$$ (eq-\2)"
    ),
    # links to equations, errata and sources; the heading of an erratum
    r"\[(Eqs?\.\s)?[\d.]+\w?\]\((?:\w+\.ipynb)?#(eq-[\w.]+)\)": r"\1{eq}`\2`",
    r"\[([^\]]+)\]\((?:22_errata\.ipynb)?#(erratum-\d+)\)": r"{ref}`\1 <\2>`",
    r"(?m)^### (\d+) · ": r"(erratum-\1)=\n\g<0>",
    r"\[[^\]]+\]\(\.\./book/references\.bib#(\w+)\)": r"{cite:t}`\1`",
}


def myst(text: str) -> str:
    """Return the text of a page from that of a notebook's cell."""
    return replaced(text, RULES)
