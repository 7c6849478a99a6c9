"""The question, the answer and the limits of an accuracy report in sentences, each carried by the rows of its run."""

import math
from collections.abc import Callable, Sequence

import pandas as pd
from gnomon.harness.contract.status import Status
from gnomon.harness.reporting.pdf.parts import Part, answer, chapter, points, table, words
from gnomon.harness.reporting.pdf.pictures import shorten
from gnomon.harness.reporting.pdf.subject import Subject, median
from gnomon.harness.reporting.tables import LAWS
from gnomon.harness.results import summary
from gnomon.harness.results.contenders import ALONE, OWN
from gnomon.harness.results.equal_error import TARGETS
from gnomon.harness.results.number_text import (
    count_text,
    error_text,
    join_words,
    power_text,
    short_text,
    tell_waits,
    time_text,
)
from gnomon.harness.results.profiles import OURS
from gnomon.harness.results.rankings import CONDITIONED, FEWEST, SOLVED
from gnomon.harness.results.time_ratios import EQUAL, EQUAL_WITHIN, FASTEST, OPEN, SLOWER

MIDDLE = 1e-6
"""The error at which the answer gives a time."""


def chapters(subject: Subject) -> list[dict[str, object]]:
    """What was asked, the answer, and its limits."""
    return [
        chapter("What was asked", words(*_list_asked(subject))),
        chapter("Answer", answer(*_answer(subject)), _kinds(subject)),
        chapter("Limits of this answer", points(*_limits(subject)), whole=True),
    ]


def join_names(names: Sequence[str], most: int = 4) -> str:
    """Names as a sentence lists them; of many the first ones, and the number of the others."""
    shown = [shorten(name, 60) for name in names[:most]]
    return join_words([*shown, f"{len(names) - most} more"]) if len(names) > most else join_words(shown)


def _list_asked(subject: Subject) -> list[str]:
    run, table_ = subject.run, subject.defaults
    noun = "physics engine" if subject.engine else "integrator"
    low, high = table_["setting"].min(), table_["setting"].max()
    if subject.by_tolerance:
        sweep = f"relative tolerances from {power_text(high)} down to {power_text(low)}"
    else:
        sizes = int(table_.groupby("case")["setting"].nunique().max())
        sweep = f"up to {count_text(sizes, 'step size')} a case, from coarse to fine"
    model = (
        "a scene of bodies, joints and contacts" if subject.engine else "the equations of motion and the initial state"
    )
    hard = subject.ran[subject.ran["variant"] != ""].drop_duplicates(["case", "variant"])
    variants = f", and on {count_text(len(hard), 'hard variant')} of them" if len(hard) else ""
    refused = (
        f" It does not accept {count_text(len(subject.refused), 'other case')} of the run." if subject.refused else ""
    )
    tried, all_ = count_text(len(subject.accepted), "case"), len(run.names)
    of = "of the run" if len(subject.accepted) == all_ else f"of the {all_} in the run"
    return [
        f"How accurately does the {noun} {subject.name} compute motions of classical mechanics, what does this cost, and"
        " where does it fail?",
        f"It was given {model} of each case, and ran at {sweep}. Its states at 64 times were compared with the exact"
        f" motion, which is known to many more digits than binary64 has. It ran on {tried} {of}{variants}.{refused}",
    ]


def _answer(subject: Subject) -> list[str]:
    few = len(subject.cases) < FEWEST
    first = _one_by_one(subject) if few else _accuracy(subject)
    second = [_setting(subject), _describe_failures(subject), _hard(subject)]
    third = [] if few else [_time(subject)]
    return [" ".join(filter(None, part)) for part in (first, second, [*third, _rank(subject)])]


def _one_by_one(subject: Subject) -> list[str]:
    """Each case of a run of few: they show nothing about others."""
    sentences = [
        f"{case}: the smallest error is {size_text(row['best'])} ({digits_text(row)} digits)"
        + (f", and one solve to an error of {power_text(MIDDLE)} takes {cost.replace('≤', 'at most')}" if cost else "")
        if math.isfinite(row["digits"])
        else f"{case}: no setting is ok ({str(row['verdict']).replace('_', ' ')})"
        for case, row in subject.cases.iterrows()
        for cost in [time_at(subject, str(case), MIDDLE)]
    ]
    number = count_text(len(subject.cases), "case")
    return [
        f"{'; '.join(sentences)}.",
        f"This run measured {number} with default numbers, which shows nothing about others.",
    ]


def _accuracy(subject: Subject) -> list[str]:
    rows, answered = subject.cases, subject.answered
    if answered.empty:
        return [f"On none of {count_text(len(rows), 'case')} with default numbers is a setting ok."]
    reached = [f"{power_text(target)} on {int((answered['best'] <= target).sum())}" for target in TARGETS]
    most, fewest = answered.iloc[0], answered.iloc[-1]
    return [
        f"Of {count_text(len(rows), 'case')} with default numbers, the smallest error over the sweep is at most"
        f" {join_words(reached)}.",
        f"At its best setting it has {median(answered['digits']):.1f} correct digits in the median of the"
        f" {count_text(len(answered), 'case')} with an ok setting, from {digits_text(fewest)} ({fewest.name}) to"
        f" {digits_text(most)} ({most.name}).",
    ]


def _setting(subject: Subject) -> str:
    """Error over tolerance, or the order, over the cases."""
    if subject.by_tolerance:
        rows = subject.cases[subject.cases["over_tolerance"].notna()]
        if rows.empty:
            return ""
        worst = rows.loc[rows["worst_over_tolerance"].idxmax()]
        middle = f"is {short_text(median(rows['over_tolerance']))} times its tolerance in the median of"
        if len(rows) < FEWEST:
            spread = range_text(rows["over_tolerance"], short_text, " to ")
            middle = f"is {spread} times its tolerance (median over the settings) on"
        return (
            f"The error {middle} {count_text(len(rows), 'case')}, and {short_text(worst['worst_over_tolerance'])} times at"
            f" the worst setting of all ({worst.name})."
        )
    rows = subject.cases[subject.cases["order"].notna()]
    declared = subject.cases["declared"].dropna()
    promise = f" (declared: {declared.iloc[0]:.0f})" if declared.nunique() == 1 else ""
    flat = list(subject.cases.index[subject.cases["flat"]])
    level = (
        f" On {count_text(len(flat), 'case')} ({join_names(flat)}) the error does not fall with the step."
        if flat
        else ""
    )
    if rows.empty:
        return f"On no case do the errors lie on a line from which an order could be measured{promise}.{level}"
    number = range_text(rows["order"], "{:.2f}".format, " to ")
    if len(rows) >= FEWEST:
        number += f", {median(rows['order']):.2f} in the median"
    return f"The order measured on {count_text(len(rows), 'case')} is {number}{promise}.{level}"


def _describe_failures(subject: Subject) -> str:
    lost = subject.cases[subject.cases["best"].isna()]
    if lost.empty:
        return "" if len(subject.cases) == 1 else "On each of these cases some setting is ok."
    why = lost["verdict"].str.replace("_", " ").value_counts()
    kinds = join_words([f"{word or 'left out'} on {number}" for word, number in why.items()])
    names = join_names(list(lost.index))
    return f"No setting is ok on {count_text(len(lost), 'case')} ({names}): {kinds}."


def _hard(subject: Subject) -> str:
    known = len(subject.hard)
    if not known:
        return ""
    return (
        f"Of {count_text(known, 'hard variant')} with a known result it solves {int(subject.hard.sum())}: an error of at most"
        f" {power_text(SOLVED)}, or {CONDITIONED:.0f} times the conditioning if that is larger."
    )


def _time(subject: Subject) -> str:
    rows = [row for (_, target), row in subject.times.items() if target == MIDDLE]
    if not rows:
        return "" if subject.times else "No time was recorded."
    seconds = pd.Series([row["seconds"] for row in rows], dtype=float)
    first = f"One solve to an error of {power_text(MIDDLE)} takes"
    if len(rows) == 1:
        return f"{first} {solve_text(seconds[0])} on the only case that reaches it."
    middle = f", {solve_text(median(seconds))} in the median" if len(rows) >= FEWEST else ""
    return f"{first} {range_text(seconds, solve_text, ' to ')} on the {len(rows)} cases that reach it{middle}."


def _rank(subject: Subject) -> str:
    division = "integrators of gnomon" if subject.library == OURS else "integrators that do not come with gnomon"
    rows = subject.equal[(subject.equal["cell"] != ALONE) & (subject.equal["target"] == MIDDLE)]
    if rows.empty:
        return f"At {power_text(MIDDLE)} no case of this run has times of several {division}."
    count = rows["state"].value_counts()
    parts = [f"{count[state]} {words}" for state, words in _STATES.items() if count.get(state, 0)]
    return f"At {power_text(MIDDLE)}, among {division}, on {count_text(len(rows), 'case')}: {', '.join(parts)}."


_STATES = {
    FASTEST: "with the least time",
    EQUAL: f"equal to it within {EQUAL_WITHIN:g} times",
    OPEN: "not told apart from it",
    SLOWER: "slower",
}
"""Words for the states of an integrator on a case."""


def _kinds(subject: Subject) -> Part:
    """A table with a row for each kind of system."""
    hard = pd.Series(subject.hard.to_numpy(), [subject.kind(str(case)) for case, _ in subject.hard.index])
    rows = []
    for kind in subject.kinds:
        own = subject.cases[subject.cases["kind"] == kind]
        if own.empty:
            continue
        good, variants = own["digits"].dropna(), hard[hard.index == kind]
        spread = range_text(good, "{:.1f}".format)
        middle = f"{good.median():.1f}" if len(good) >= FEWEST else "–"
        solved = f"{variants.sum():.0f} of {len(variants)}" if len(variants) else "–"
        reached = str(int((own["best"] <= MIDDLE).sum()))
        rows.append([kind, str(len(own)), reached, middle, spread, *([solved] if len(hard) else [])])
    heads = ["<>kind of system", ">cases", f">error ≤ {power_text(MIDDLE)}", ">median digits", ">digits, fewest – most"]
    heads += [">hard variants solved"] if len(hard) else []
    note = f"Digits at the best setting of each case; no median is given of fewer than {FEWEST} cases."
    return table(heads, rows, note, "By kind of system")


def _limits(subject: Subject) -> list[str]:
    return [text for text in (*_of_run(subject), *_of_errors(subject), *_of_times(subject)) if text]


def _of_run(subject: Subject) -> list[str]:
    texts = [
        f"It holds for the {count_text(len(subject.accepted), 'case')} of this report and their numbers. Other motions may"
        " behave otherwise; the cases are not a random sample of anybody's problems."
    ]
    planned = [row for row in subject.run.outstanding.planned if row.library == subject.library]
    lost = sum(row.trials - row.measured for row in planned)
    if lost:
        texts.append(
            f"The run is not complete: {lost} of the {sum(row.trials for row in planned)} trials planned for the library"
            f" {subject.library} have no measurement. Cases, and settings of cases, may be missing."
        )
    skipped = subject.ran[subject.ran["status"].isin([Status.SKIPPED, Status.TIMEOUT])]
    limits = subject.ran["limit_seconds"].dropna()
    if len(skipped) and len(limits):
        low, high = f"{limits.min():g}", f"{limits.max():g}"
        most = f"{low} s" if low == high else f"{low} to {high} s, according to the case,"
        texts.append(
            f"A trial may take {most} here: {count_text(len(skipped), 'setting')} passed this limit or"
            " were not started because of it. With more time, errors may be smaller."
        )
    return texts


def _of(some: int, answered: int) -> str:
    """Some of the cases with an answer."""
    return f"{some} of {answered} cases" if some < answered else "each case" if answered > 1 else "the one case"


def _of_errors(subject: Subject) -> list[str]:
    answered, texts = subject.answered, []
    if answered.empty:
        return []
    number = len(answered)
    turned = int((answered["turned_starts"] > 0).sum())
    if turned:
        texts.append(
            f"On {_of(turned, number)} the error is the median over turned orientations, with its range in the table."
        )
    if turned < len(answered):
        texts.append(
            f"On {_of(len(answered) - turned, number)} the error is that of one start: it has no range, and another start"
            " may give a larger or smaller error."
        )
    tight = int((answered["tightest"] & ~answered["at_floor"]).sum())
    if tight:
        texts.append(
            f"On {_of(tight, number)} the best setting is the finest that ran: a finer one may give more digits, so the"
            " digits are a lower bound there."
        )
    lost = int((answered["attainable"] > MIDDLE).sum())
    if lost:
        texts.append(
            f"On {_of(lost, number)} half a unit in the last place of the input changes the exact motion by more than"
            f" {power_text(MIDDLE)}: no method can be trusted beyond that there."
        )
    texts.append(
        "Errors are measured at 64 times of each motion: between them, and after the last one, nothing was measured. An"
        " error smaller than the floor, half a unit in the last place of the exact states, counts as the floor."
    )
    return texts


def _of_times(subject: Subject) -> list[str]:
    timed = subject.run.frame[subject.run.frame["integrator_id"] == subject.name]
    if not timed["seconds_median"].notna().any():
        return []
    waited = tell_waits(
        *summary.count_waits(zip(subject.frame["seconds_median"], subject.frame["delay_seconds"], strict=True))
    )
    processor = shorten(subject.environment.get("cpu", "not recorded"), 80)
    return [
        f"Times are of whole calls on one processor model ({processor}), geometric means over launches;"
        f" {subject.run.scatter[OWN].text()}. {waited[:1].upper()}{waited[1:]}."
    ]


def digits_text(row: pd.Series) -> str:
    """The digits of a row of `Subject.cases`; with a sign if only a bound was measured."""
    if not math.isfinite(row["digits"]):
        return "–"
    return f"≥ {row['digits']:.1f}" if row["at_floor"] else f"{row['digits']:.1f}"


def size_text(error: float) -> str:
    """An error to two figures; 0 if it is zero."""
    return "0" if error == 0 else error_text(error)


def solve_text(seconds: float) -> str:
    """A time to two figures: launches differ by some percent."""
    return time_text(seconds, 2)


def range_text(values: pd.Series, text: Callable[[float], str], between: str = " – ") -> str:
    """The least and the greatest value in words; the value alone if they read the same."""
    if values.empty:
        return "–"
    return between.join(dict.fromkeys((text(float(values.min())), text(float(values.max())))))


def time_at(subject: Subject, case: str, target: float) -> str:
    """The time at an error on a case, with its range over launches; empty if the error is not reached."""
    row = subject.times.get((case, target))
    if row is None:
        return ""
    bound = "≤ " if row["at_loosest"] else ""
    spread = f" ({range_text(pd.Series([row['low'], row['high']]), solve_text)})" if row["launches"] > 1 else ""
    middle = solve_text(row["seconds"])
    return bound + middle + spread.replace(f" ({middle})", "")


def growth_words(subject: Subject) -> str:
    """On how many cases the error grows by which law."""
    laws = pd.Series([law.law for _, law in subject.grown.values()], dtype=object)
    if laws.empty:
        return ""
    clear = laws[laws != ""].map(lambda law: LAWS.get(law, law)).value_counts()
    counted = join_words([f"{law} on {number}" for law, number in clear.items()])
    open_ = int((laws == "").sum())
    rest = f"on {open_} its interval admits several laws" if open_ else ""
    return f"Of {count_text(len(laws), 'case')} with stored states, the growth of the error is: {'; '.join(filter(None, [counted, rest]))}."
