"""Sentences and tables of a notebook whose numbers come from its run."""

import re
from collections.abc import Iterable, Sequence
from functools import partial
from inspect import cleandoc

from cmtof.types import Texts
from cmtof_book import record

NUMBER = re.compile(r"\W*(\d|inf|nan|$)")
# How a table sets powers of ten, minus signs and comparisons, and where it breaks no line.
TYPESET = {
    r"(?<![\w`])(\d[\d.]*)e\+?(-?)0*(\d+)\b": "\\1\u00a0×\u00a010<sup>\\2\\3</sup>",
    r"(?<![\w`-])-(?=\d)": "−",
    r" ([<≥]) ": "\u00a0\\1\u00a0",
    "–": "\u2060–\u2060",
    r" \(": "\u00a0(",
}


def _show(kind: str, text: str, /, **numbers: float | str) -> None:
    """Show a paragraph of Markdown with numbers of this run where it has ``{name:.2f}``."""
    record.add(record.TEXT, numbers)
    record.show({"text/markdown": cleandoc(text).format(**numbers)}, kind)


say = partial(_show, "text")
# to a chapter's question, repeated at the head of its page
answer = partial(_show, "answer")


def table(
    head: Sequence[str], rows: Iterable[Sequence[object]], *, fold: str = ""
) -> None:
    """Show a table of texts under the cell; columns of numbers but the first are right-aligned.

    Powers of ten and minus signs are set as such, and a comparison stays on one line. A long table
    may ``fold`` under a title.
    """
    from IPython.display import Markdown, display

    titles, *texts = [
        [str(x).replace("|", r"\|") for x in line] for line in (head, *rows)
    ]
    sides = [
        "--:" if all(map(NUMBER.match, column)) else ":--"
        for column in zip(*texts, strict=True)
    ]
    lines = (titles, [":--", *sides[1:]], *texts)
    text = replaced("\n".join(f"| {' | '.join(line)} |" for line in lines), TYPESET)
    if fold:
        text = f"<details><summary>{fold}</summary>\n\n{text}\n\n</details>"
    display(Markdown(text))


def replaced(text: str, rules: Texts) -> str:
    """Replace one pattern after another by its text."""
    for pattern, put in rules.items():
        text = re.sub(pattern, put, text)
    return text
