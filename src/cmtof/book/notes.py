"""Numbers and tables that a notebook puts into its page."""

from collections.abc import Iterable, Sequence


def tell(**numbers: float) -> None:
    """Glue numbers, so that the text can show them as ``{glue:text}`name:.2f` ``."""
    from myst_nb import glue

    for name, value in numbers.items():
        glue(name, float(value), display=False)


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Show a table of texts under the cell; the first column is left-aligned, others right."""
    from IPython.display import Markdown, display

    lines = [head, [":--", *["--:"] * (len(head) - 1)], *rows]
    text = "\n".join("| " + " | ".join(str(x) for x in line) + " |" for line in lines)
    display(Markdown(text.replace("–", "\u2060–\u2060").replace(" (", "\u00a0(")))  # unbroken
