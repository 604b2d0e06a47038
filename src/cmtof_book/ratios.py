"""The scoreboard as one picture: our results over the paper's, a line for each number.

It is HTML with a small drawing in each line, so that it reads on a phone and in the dark. The
script of the book hides the lines that a reader does not want.
"""

import math
from collections.abc import Iterable, Mapping
from html import escape

from cmtof_book.paper import Published, published_numbers, result_text
from cmtof_book.verdict import Estimate, Outcome, Result, differing, verdict

SPAN = 30  # greatest ratio that is drawn, and its inverse
SHOWN: tuple[Outcome, ...] = ("reproduced", "contradicted", "open")

FRAME = """```{{raw}} html
<figure class="ratios" role="group" aria-label="{alt}">
<p class="choices" hidden>{choices}</p>
<p class="scale"><span>1/{span}</span><span>the paper</span><span>{span} ×</span></p>
<ol>
{lines}
</ol>
</figure>
```
"""

LINE = (
    '<li data-verdict="{said}" data-same="{same}" title="{title}"><span>{what}</span>'
    '<svg viewBox="0 0 100 {height}" preserveAspectRatio="none" aria-hidden="true">'
    '<path class="paper" d="M50 0V{height}"/>{drawn}</svg></li>'
)


def picture(results: Mapping[str, Result]) -> str:
    """Return the picture as MyST Markdown."""
    lines = list(_lines(results))
    counts = [sum(f'verdict="{one}"' in text for text in lines) for one in SHOWN]
    kinds = [f"{one} ({count})" for one, count in zip(SHOWN, counts, strict=True)]
    alt = (
        f"Ratios of {len(lines)} results to the paper's numbers on a logarithmic scale, with 95 % "
        f"intervals. {', '.join(kinds)}. The tables below hold all numbers."
    )
    choices = [_choice("verdict", one, text) for one, text in zip(SHOWN, kinds, strict=True)]
    choices += [_choice("same", "yes", "same data and training")]
    choices += [_choice("same", "no", "something differs")]
    return FRAME.format(alt=alt, choices=" ".join(choices), span=SPAN, lines="\n".join(lines))


def _choice(field: str, value: str, text: str) -> str:
    box = f'<input type="checkbox" checked data-field="{field}" value="{value}">'
    return f"<label>{box} {text}</label>"


def _lines(results: Mapping[str, Result]) -> Iterable[str]:
    """A line for each result with a verdict, the worst place of it first."""
    for number in published_numbers().values():
        result = results.get(number.key)
        said = verdict(number, result)
        if result and said in SHOWN and number.value:
            drawn = [_mark(number, one, place) for place, one in enumerate(result.cases.values())]
            yield LINE.format(
                said=said,
                same="no" if differing(number, result) else "yes",
                title=escape(f"{number.text()}; ours {result_text(number, result)}: {said}"),
                what=f"{escape(number.what)} <i>{number.where.partition(',')[0]}</i>",
                height=10 * len(drawn),
                drawn="".join(drawn),
            )


def _mark(number: Published, one: Estimate, place: int) -> str:
    """A dot at the ratio, and a line over the interval; what lies beyond ends at the edge."""
    low, value, high = (_across(end / number.value) for end in (one.low, one.value, one.high))
    y = 10 * place + 5
    line = f'<path d="M{low} {y}H{high}"/>' if high > low else ""
    return f'{line}<path class="dot" d="M{value} {y}h0"/>'


def _across(ratio: float) -> float:
    """Place of a ratio between the edges, 0 and 100."""
    held = min(max(ratio, 1 / SPAN), SPAN)
    return round(50 + 48 * math.log(held) / math.log(SPAN), 1)
