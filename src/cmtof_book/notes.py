"""Numbers and tables that a notebook puts into its page."""

import re
from collections.abc import Iterable, Sequence

from cmtof_book import record

NUMBER = re.compile(r"\W*(\d|inf|nan|$)")
POWER = re.compile(r"(?<![\w`])(\d[\d.]*)e\+?(-?)0*(\d+)\b")


def tell(**numbers: float) -> None:
    """Glue numbers, so that the text can show them as ``{glue:text}`name:.2f` ``."""
    from myst_nb import glue

    record.add(record.TEXT, numbers)
    for name, value in numbers.items():
        glue(name, float(value), display=False)


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Show a table of texts under the cell; columns of numbers but the first are right-aligned.

    Powers of ten and minus signs are set as such, and a comparison stays on one line.
    """
    from IPython.display import Markdown, display

    titles, *texts = [[str(x).replace("|", r"\|") for x in line] for line in (head, *rows)]
    numbers = [all(map(NUMBER.match, column)) for column in zip(*texts, strict=True)]
    lines = [titles, [":--", *("--:" if one else ":--" for one in numbers[1:])], *texts]
    text = "\n".join("| " + " | ".join(line) + " |" for line in lines)
    text = POWER.sub("\\1\u00a0×\u00a010<sup>\\2\\3</sup>", text)
    text = re.sub(r"(?<![\w`-])-(?=\d)", "−", text)
    text = re.sub(r" ([<≥]) ", "\u00a0\\1\u00a0", text)
    for broken in ("–", "\u2060–\u2060"), (" (", "\u00a0("):
        text = text.replace(*broken)
    display(Markdown(text))
