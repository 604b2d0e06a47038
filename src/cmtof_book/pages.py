"""Generated pages of the book: each is a template of ``templates``, filled with values."""

from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from cmtof_book.paper import published_text, result_text

TEMPLATES = Environment(
    loader=PackageLoader("cmtof_book"),
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
)
TEMPLATES.filters |= {"ours": result_text, "published": published_text}


def page(template: str, **values: Any) -> str:
    """Return a page as MyST Markdown; an error where a value is missing that it shows."""
    return TEMPLATES.get_template(f"{template}.jinja").render(values)
