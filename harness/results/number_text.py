"""Numbers in words, with their units, as the command line and the report show them."""

import math
from collections.abc import Sequence

from gnomon.harness.measuring.outcome import DELAYED
from gnomon.harness.results.summary import Load


def count_text(number: int, noun: str) -> str:
    """A number with its noun in singular or plural: 1 case, 2 cases, 0 libraries."""
    if number == 1:
        return f"1 {noun}"
    return f"{number} {noun[:-1]}ies" if noun.endswith("y") else f"{number} {noun}s"


def lower_first(text: str) -> str:
    """Words as they stand within a sentence: names in them keep their capitals."""
    return text[:1].lower() + text[1:]


def join_words(words: Sequence[str]) -> str:
    """Words as a sentence lists them: one, two and three."""
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def group_digits(number: int) -> str:
    """A number with its digits in groups of three."""
    return f"{number:,}".replace(",", "\N{NO-BREAK SPACE}")


def time_text(seconds: float, figures: int = 3) -> str:
    """A time with `figures` significant figures and its unit."""
    if not math.isfinite(seconds):
        return "–"
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= (1 - 0.5 * 10**-figures) * size:  # a time that rounds to 1000 of a unit is 1 of the next
            return f"{figures_text(seconds / size, figures)} {unit}"
    return f"{figures_text(seconds * 1e9, figures)} ns"


def figures_text(value: float, figures: int = 2) -> str:
    """A number with `figures` significant figures, with zeros at the end too: 1.0, 12, 370."""
    rounded = f"{value:.{figures - 1}e}"
    return f"{float(rounded):.{max(figures - 1 - int(rounded.partition('e')[2]), 0)}f}"


def error_text(error: float) -> str:
    """An error to two figures, as 1.2e-9."""
    if not math.isfinite(error):
        return "–"
    mantissa, _, exponent = f"{error:.1e}".partition("e")
    return f"{mantissa}e{int(exponent)}"


def power_text(error: float) -> str:
    """The text of a power of ten, as 1e-6."""
    return error_text(error).replace("1.0e", "1e")


def short_text(value: float) -> str:
    """A number to two figures, with an exponent only where it is very large or small: 0.43, 12, 1.2e-9."""
    if not math.isfinite(value):
        return "–"
    return figures_text(value, 2 + (value >= 99.5)) if 0.00995 <= value < 999.5 else error_text(value)


def order_text(order: float, margin: float) -> str:
    """An order with half of its 95 % interval, rounded up; "no order" if the interval holds 0: the error does not fall."""
    return f"{order:.2f} ± {max(math.ceil(100 * margin), 1) / 100:.2f}" if order > margin else "no order"


def tell_waits(timed: int, delayed: int, unknown: int) -> str:
    """The numbers of `summary.count_waits` in words."""
    text = f"{delayed} of {count_text(timed, 'timed measurement')} include more than {DELAYED:.0%} of waiting for a processor"
    return text.replace("%", " %") + (f"; of {unknown} it is not known" if unknown else "")


def load_text(load: Load) -> str | None:
    """A warning if the machine was under load; None if it was not."""
    if not load.high:
        return None
    return (
        f"the machine was under load: {100 * load.share:.0f} % of the timed measurements waited for a processor, on a quiet machine"
        " some 2 %; errors are right, times may not be: run again on a quiet machine to compare times"
    )


def duration_text(seconds: float) -> str:
    """A duration to the second: "41 s", "14 min 20 s", "1 h 5 min"."""
    minutes, rest = divmod(round(seconds), 60)
    if minutes >= 60:
        return f"{minutes // 60} h {minutes % 60} min"
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"


def ratio_text(ratio: float) -> str:
    """A ratio to two or three figures."""
    if not math.isfinite(ratio):
        return "–"
    return f"{ratio:.1f}" if ratio < 9.95 else f"{ratio:,.0f}".replace(",", "\u202f")


def problem_name(case: str, variant: str, formulation: str) -> str:
    """The name of a problem in every table: case/variant (formulation)."""
    return case + (f"/{variant}" if variant else "") + (f" ({formulation})" if formulation else "")
