"""Sentences and tables of a notebook whose numbers come from its run."""

import re
from collections.abc import Iterable, Sequence
from inspect import cleandoc

from cmtof_book import record

NUMBER = re.compile(r"\W*(\d|inf|nan|$)")
POWER = re.compile(r"(?<![\w`])(\d[\d.]*)e\+?(-?)0*(\d+)\b")


def say(text: str, **numbers: float | str) -> None:
    """Show a paragraph of Markdown with numbers of this run where it has ``{name:.2f}``."""
    _show("text", text, numbers)


def answer(text: str, **numbers: float | str) -> None:
    """Show the answer to a chapter's question, which the book repeats at the head of its page."""
    _show("answer", text, numbers)


def _show(kind: str, text: str, numbers: dict[str, float | str]) -> None:
    from IPython.display import display

    record.add(record.TEXT, numbers)
    said = cleandoc(text).format(**numbers)
    display({"text/markdown": said}, raw=True, metadata=record.page_metadata(kind))


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
    numbers = [all(map(NUMBER.match, column)) for column in zip(*texts, strict=True)]
    lines = [titles, [":--", *("--:" if one else ":--" for one in numbers[1:])], *texts]
    text = "\n".join("| " + " | ".join(line) + " |" for line in lines)
    text = POWER.sub("\\1\u00a0×\u00a010<sup>\\2\\3</sup>", text)
    text = re.sub(r"(?<![\w`-])-(?=\d)", "−", text)
    text = re.sub(r" ([<≥]) ", "\u00a0\\1\u00a0", text)
    for broken in ("–", "\u2060–\u2060"), (" (", "\u00a0("):
        text = text.replace(*broken)
    if fold:
        text = f"<details><summary>{fold}</summary>\n\n{text}\n\n</details>"
    display(Markdown(text))
