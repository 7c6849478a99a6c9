"""A program in any language is an integrator: right where it is right, and one clear reason where it is not."""

import json
import math
import os
import shlex
import shutil
import subprocess
import sys
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from command_line import gnomon
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.integrator import Integrator, Problem, Refused, Solution, Steps, Unsupported
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.contract.status import Status
from gnomon.harness.contract.validation import Unusable
from gnomon.harness.measuring import trials
from gnomon.harness.measuring.outcome import Outcome
from gnomon.harness.measuring.reference_solution import CaseSpec, reference_solution
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.registry import lookup, references
from gnomon.harness.running import plan, pool, worker
from gnomon.harness.running.sweep import task_of
from gnomon.harness.system import supervisor
from gnomon.harness.verification import program_process, protocol
from gnomon.harness.verification.claims import DEPTHS
from gnomon.harness.verification.program_adapter import from_command
from turned_clock import Clock
from waiting import LONG_SECONDS

from gnomon import cases

HERE = Path(__file__).parent
EXAMPLE = HERE.parents[1] / "example_project"
COMPILER = shutil.which("cc")
PROCESSOR_CLOCK = trials._clock
SCHEMA: dict[str, Any] = json.loads(
    files("gnomon.harness.verification").joinpath("protocol.schema.json").read_text(encoding="utf-8")
)
pytestmark = pytest.mark.skipif(os.name != "posix", reason="worker processes need POSIX")


def valid(line: str, kind: str) -> bool:
    """Whether a line is JSON that a definition of the schema admits."""
    schema = {"$ref": f"#/$defs/{kind}", "$defs": SCHEMA["$defs"]}
    try:
        found = json.loads(line, parse_constant=pytest.fail if kind == "request" else None)
    except (ValueError, RecursionError):
        return False
    return bool(jsonschema.Draft202012Validator(schema).is_valid(found))


def odd(way: str, **options: Any) -> Any:
    return from_command([sys.executable, str(HERE / "odd_program.py"), way], **options)


def pendulum(integrator: Integrator, counted: bool = False) -> tuple[Problem, np.ndarray[Any, Any]]:
    case = cases.get("pendulum_simple").rounded()
    return problem_of(case, integrator.accepts, counted=counted), initial_state(case)[None]


def solved(integrator: Integrator) -> Solution:
    problem, start = pendulum(integrator)
    return integrator.prepare(problem, problem.interval)(start)


@pytest.fixture(scope="module")
def rk4(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if COMPILER is None:
        pytest.skip("needs a C compiler called cc")
    program = tmp_path_factory.mktemp("rk4") / "rk4"
    subprocess.run(
        [COMPILER, "-O2", "-ffp-contract=off", "-o", program, EXAMPLE / "swing" / "rk4.c", "-lm"], check=True
    )
    return program


def classical(problem: Problem, start: np.ndarray[Any, Any], h: float) -> np.ndarray[Any, Any]:
    """The same method in Python, on the case's own equations; states (64, dim)."""
    assert isinstance(problem.form, FirstOrder)
    f, p = problem.form.equations, tuple(problem.parameters.tolist())
    y, found = start.copy(), []
    for _ in problem.times:
        for _ in range(round(problem.interval / h)):
            k1 = np.array(f(0.0, tuple(y), p))
            k2 = np.array(f(0.0, tuple(y + h / 2 * k1), p))
            k3 = np.array(f(0.0, tuple(y + h / 2 * k2), p))
            k4 = np.array(f(0.0, tuple(y + h * k3), p))
            y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        found.append(y)
    return np.array(found)


@pytest.mark.parametrize("name", ["pendulum_simple", "kepler_orbit"])
def test_a_program_in_c_computes_what_its_method_computes(rk4: Path, name: str) -> None:
    """Over the first quarter of the span, where the case multiplies rounding by less than 1e3."""
    integrator = from_command([str(rk4)])
    case = cases.get(name).rounded()
    problem, start = problem_of(case, integrator.accepts, counted=True), initial_state(case)
    h = problem.interval / 8
    solution = integrator.prepare(problem, h)(start[None])
    own = classical(problem, start, h)[:16]
    assert np.max(np.abs(solution.states[0, :16] - own)) < 1e-12 * np.max(np.abs(own))
    assert solution.steps == 64 * 8
    assert problem.buffer[-1] == 4 * 64 * 8


DOCUMENTED = {"cpp": ("c++", ["-O2", "-o"]), "rust": ("rustc", ["-O", "-o"])}
"""Languages of docs/any_language.md that are compiled: the compiler, and its options before the name of the program."""


@pytest.fixture(scope="module", params=["c", *DOCUMENTED])
def example(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The programs that the documentation shows."""
    if request.param == "c":
        found: Path = request.getfixturevalue("rk4")
        return found
    name, options = DOCUMENTED[request.param]
    compiler = shutil.which(name)
    if compiler is None:
        pytest.skip(f"needs a compiler called {name}")
    text = (HERE.parents[2] / "docs" / "any_language.md").read_text().split(f"```{request.param}\n")[1].split("```")[0]
    program = tmp_path_factory.mktemp(request.param) / "example"
    source = program.with_suffix(".cpp" if request.param == "cpp" else ".rs")
    source.write_text(text)
    subprocess.run([compiler, *options, program, source], check=True)
    return program


@pytest.mark.parametrize("setting", [0.0, -1e-3, math.nan])
def test_an_example_refuses_a_setting_that_is_no_step(example: Path, setting: float) -> None:
    integrator = from_command([str(example)], seconds=LONG_SECONDS)
    problem, start = pendulum(integrator)
    with pytest.raises(Refused):
        integrator.prepare(problem, setting)(start)


def test_what_an_example_writes_of_a_start_that_is_not_finite_is_json(example: Path) -> None:
    integrator = from_command([str(example)], seconds=LONG_SECONDS)
    problem, start = pendulum(integrator)
    for value in (math.nan, math.inf):
        states = integrator.prepare(problem, problem.interval)(np.full_like(start, value)).states
        assert not np.any(np.isfinite(states))
    assert np.all(np.isfinite(integrator.prepare(problem, problem.interval)(start).states))


@pytest.mark.parametrize("setting", [0.0, -1e-3, math.nan])
def test_a_setting_that_is_no_number_is_sent_as_json(setting: float) -> None:
    problem, start = pendulum(from_command([sys.executable, str(HERE / "odd_program.py"), "right"]))
    line = protocol.problem_line(protocol.problem_parts(problem, "step", setting), 1, start[0])
    assert valid(line, "request")


def test_a_program_gets_the_time_of_the_start(rk4: Path) -> None:
    """The pendulum does not depend on time, and sums of times with 3.25 s are exact: not a bit changes."""
    integrator = from_command([str(rk4)])
    problem, start = pendulum(integrator)
    late = replace(problem, times=problem.times + 3.25, t0=3.25)
    states = [integrator.prepare(given, problem.interval / 8)(start).states for given in (problem, late)]
    assert np.array_equal(*states)


def test_a_run_of_a_program_measures_its_order_its_counts_and_its_time(
    rk4: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    from gnomon.harness.results.store import load

    results = tmp_path / "results.sqlite"
    chosen = ("--case", "pendulum_simple", "--case", "euler_top")
    asked = (
        "--command",
        shlex.quote(str(rk4)),
        "--suite",
        "quick",
        "--limit",
        str(LONG_SECONDS),
        "--out",
        str(results),
    )
    assert gnomon("run", *chosen, *asked) == 0
    capfd.readouterr()
    frame = load(results)
    assert set(frame["integrator_id"]) == {"command:RK4 in C"}
    frame = frame[frame["formulation"] == "standard"]
    top = frame[frame["case"] == "euler_top"].sort_values("setting", ascending=False)
    assert top["status"].iloc[0] == Status.UNSUPPORTED
    assert set(top["status"][1:]) == {Status.SKIPPED}
    assert top["reason"].iloc[0] == "lacks this case"
    good = frame[(frame["case"] == "pendulum_simple") & (frame["status"] == Status.OK)].sort_values("setting")
    finest = good[good["error_max"] > 1000 * good["conditioning"]].head(2)  # rounding is below 0.1 % of these errors
    (fine, coarse), (short, long) = finest["error_max"], finest["setting"]
    assert abs(math.log(coarse / fine) / math.log(long / short) - 4) < 0.2
    assert (good["rhs_calls"] == 4 * good["steps"]).all()
    assert good["null_seconds"].notna().all()


class Recording:
    """The jobs of a pool, reduced to the outcome of each trial."""

    def __init__(self, integrator: Integrator, trials: int, limit_seconds: float) -> None:
        case = cases.get("pendulum_simple").rounded()
        series = plan.Series(case, None, integrator)
        self.task = task_of(series, reference_solution(CaseSpec.of(case)))
        self.limit_seconds, self.left, self.found = limit_seconds, trials, list[tuple[str, str]]()

    def next(self) -> worker.Request | None:
        self.left -= 1
        return None if self.left < 0 else worker.Request(0.125, False, 0.0, 1, 1.0)

    def done(self, outcome: Outcome) -> None:
        self.found.append(("done", ""))

    def failed(self, status: Status, reason: str, output: str, tries: int | None = None) -> None:
        self.found.append((status, reason))


def test_one_process_serves_the_trials_of_a_series() -> None:
    """It prints its number: one process in all trials, though a worker ends other processes that a trial leaves."""
    job = Recording(odd("who"), 3, LONG_SECONDS)
    pool.Pool(1).run([job])
    assert len(job.found) == 3
    assert {status for status, _ in job.found} == {Status.REFUSED}
    assert len({reason for _, reason in job.found}) == 1


def running(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(") ")[2][0]
    except OSError:
        return False
    return state != "Z"


@pytest.mark.skipif(sys.platform != "linux", reason="processes are looked for in /proc")
def test_a_time_limit_ends_the_program_and_all_that_it_started(tmp_path: Path, clock: Clock) -> None:
    place = tmp_path / "pids"
    command = f"env GNOMON_TEST_PIDS={place} {sys.executable} {HERE / 'odd_program.py'} 'hang with children'"
    job = Recording(from_command(command), 1, 3.0)
    pool.Pool(1).run([job])
    assert job.found == [(Status.TIMEOUT, "no answer within 3 s")]
    started = [int(number) for number in place.read_text().split()]
    assert len(started) == 2
    assert not [process for process in started if running(process)]


def test_outside_a_run_the_door_has_a_time_limit_of_its_own(clock: Clock) -> None:
    """Ten times the limit of processor time is the limit by the clock: a program that waits does not hang."""
    assert solved(odd("wait", seconds=0.5)).steps == 64
    assert clock.now == 1
    for clock.burning, why in ((False, "within 3 s"), (True, "within 0.3 s of processor time")):
        with pytest.raises(TimeoutError, match=f"no answer {why}$"):
            solved(odd("hang", seconds=0.3))


def test_the_time_of_a_program_is_that_of_its_solutions(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sweep ends at the first setting that takes too long, which the program itself spends: a tenth of a second of
    processor time or, on a slow machine, more."""
    monkeypatch.setattr(trials, "_clock", PROCESSOR_CLOCK)
    case = cases.get("pendulum_simple").rounded()
    depth = replace(DEPTHS["low"], seconds=0.05)
    answers = Trials.of(odd("slow"), CaseSpec.of(case), depth).answers()
    assert len(answers) == 1
    assert answers[0].seconds > 0.05


@pytest.mark.parametrize(
    ("way", "reason"),
    [
        ("garbage", "'hello', which is not JSON"),
        ("list", "a reply is a JSON object"),
        ("deep", "nested too deeply|not JSON"),
        ("plain nan", 'NaN is not JSON: write "nan"'),
        ("other number", "replied to number 2 where 1 was asked"),
        ("true number", "replied to number True"),
        ("no status", "status = None: it is ok, stopped, refused or unsupported"),
        ("odd status", "status = 'fine'"),
        ("few states", "63 states for 64 times"),
        ("many states", "65 states for 64 times"),
        ("no states", "states = None"),
        ("wide state", r"states\[0\] = .*a list of 2 numbers"),
        ("true state", r"states\[0\]\[0\] = True"),
        ("text state", r"states\[0\]\[0\] = 'much'"),
        ("odd hex", r"states\[0\]\[0\] = '0xyz'"),
        ("odd steps", "steps = -1: a count"),
        ("huge steps", "steps = 1000.*: a count"),
        ("half steps", "steps = 1.5: a count"),
        ("no reason", "reason = None: it is a text"),
        ("lacks nothing", "lacks = None: it is a text"),
        ("no counts", "no rhs_calls, which it declares"),
        ("exit", "ended with exit code 3 before it answered"),
        ("signal", "died of SIGABRT before it answered"),
        ("within a line", "exit code 0 within a line before it answered"),
        ("long line", "a line of more than 4194304 bytes"),
        ("bytes", "not UTF-8"),
    ],
)
def test_a_wrong_answer_has_one_clear_reason(way: str, reason: str) -> None:
    """`Unusable` is the status crashed, with its text as the reason. The next trial has a new process."""
    integrator = odd(way, seconds=LONG_SECONDS)
    for _ in range(2):
        with pytest.raises(Unusable, match=reason) as caught:
            solved(integrator)
        assert "\n" not in str(caught.value)
        assert len(str(caught.value)) < 300


def test_a_second_line_is_noticed_at_the_next_problem() -> None:
    integrator = odd("two lines", seconds=LONG_SECONDS)
    problem, start = pendulum(integrator)
    solve = integrator.prepare(problem, problem.interval)
    solve(start)
    with pytest.raises(Unusable, match=r"more than one line|number 1 where 2"):
        solve(start)


def test_what_a_program_says_of_itself_is_a_status() -> None:
    with pytest.raises(Refused, match=r"^steps this large diverge$"):
        solved(odd("refused"))
    with pytest.raises(Unsupported, match=r"^lacks elliptic functions$"):
        solved(odd("unsupported"))
    early = solved(odd("stopped"))
    assert early.stopped == "a pole"
    assert np.isfinite(early.states[0, 0]).all()
    assert np.isnan(early.states[0, 1:]).all()


def test_numbers_that_are_not_finite_and_hexadecimal_digits_are_read() -> None:
    states = solved(odd("encoded")).states[0]
    assert math.isnan(states[0, 0])
    assert states[0, 1] == math.inf
    assert states[1].tolist() == [-math.inf, 3.0]
    assert states[2].tolist() == [1.0, math.inf]


@pytest.mark.parametrize(
    ("way", "reason"),
    [
        ("mute", "ended with exit code 0 before it answered"),
        ("other protocol", "protocol = 2: it is 1, the version"),
        ("no sweep", "'sweep' is a required property"),
        ("odd sweep", "sweep.kind = 'guess'"),
        ("odd step", "sweep.coarsest = 'large'"),
        ("huge step", "coarsest is a finite"),
        ("odd form", r"forms\[0\] = 'Hamiltonian'"),
        ("odd order", "order = -4"),
        ("huge order", "order = 1000"),
        ("odd name", "name = "),
        ("odd counts", "counts_rhs = 'yes'"),
        ("nan", "NaN is not JSON"),
    ],
)
def test_a_wrong_description_is_wrong_usage(way: str, reason: str) -> None:
    with pytest.raises(ValueError, match=reason) as caught:
        odd(way)
    assert "--command" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_last_lines_of_standard_error_stand_in_the_message_without_a_traceback(
    capfd: pytest.CaptureFixture[str],
) -> None:
    """A program that stops says why there: the user reads it, not our code."""
    program = shlex.join([sys.executable, str(HERE / "odd_program.py"), "last words"])
    assert gnomon("verify", "--command", program, "--case", "pendulum_simple", "--depth", "low") == 1
    said = capfd.readouterr().err
    assert "exit code 0 before it answered" in said
    assert "corrector convergence failed\n PROGRAM STOP" in said
    assert "Traceback" not in said
    assert said.count("step 1") < 10


def test_standard_error_of_a_program_that_answers_is_passed_on(capfd: pytest.CaptureFixture[str]) -> None:
    solved(odd("talks"))
    assert capfd.readouterr().err == "step 1\n"


def test_a_program_that_never_describes_itself_is_ended_after_60_s_by_the_clock(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The clock goes on by each wait for an answer, which takes no time here: nothing but the limits ends the wait."""
    now = [0.0]

    def wait(_sources: object, seconds: float) -> None:
        now[0] += seconds + 0.01

    monkeypatch.setattr(supervisor, "wait", wait)
    for module in (supervisor, program_process):
        monkeypatch.setattr(module, "monotonic", lambda: now[0])
    with (
        pytest.warns(UserWarning, match="not described itself in 10 s, and has 60 s") as told,
        pytest.raises(ValueError, match="does not describe itself: no answer within 60 s"),
    ):
        odd("silent")
    assert len(told) == 1
    assert 60 <= now[0] < 600, "the time in which the process waited for a processor is added"


@pytest.mark.parametrize("name", ["pendulum_simple", "two_body", "euler_top", "projectile_quadratic_drag"])
def test_problems_follow_the_schema_and_hold_every_number_exactly(name: str) -> None:
    integrator = odd("fine")
    case = cases.get(name).rounded()
    problem = problem_of(case, integrator.accepts)
    parts = protocol.problem_parts(problem, Steps.kind, 0.1)
    line = protocol.problem_line(parts, 7, initial_state(case))
    assert valid(line, "request")
    found = json.loads(line)
    assert "\n" not in line
    assert found["case"] == name
    assert float.fromhex(found["setting"]["hex"]) == 0.1 == found["setting"]["value"]
    for key, exact in (("times", problem.times.tolist()), ("start", [float(x) for x in case.initial_state])):
        assert found[key] == exact
        assert [float.fromhex(x) for x in found[f"{key}_hex"]] == exact
    values = {parameter: float(value) for parameter, value in case.parameters.items()}
    assert found["parameters"] == values
    assert {parameter: float.fromhex(x) for parameter, x in found["parameters_hex"].items()} == values


def test_a_start_that_is_not_finite_is_still_json() -> None:
    integrator = odd("fine")
    problem, _ = pendulum(integrator)
    line = protocol.problem_line(protocol.problem_parts(problem, "step", 0.1), 1, np.array([math.nan, -math.inf]))
    assert valid(line, "request")
    assert json.loads(line)["start"] == ["nan", "-inf"]


def admitted(line: str) -> bool:
    """Whether the code takes a reply to problem 1, whose states are (64, 2)."""
    try:
        protocol.reply(line, 1, (64, 2))
    except Unusable:
        return False
    except Refused:
        pass
    return True


def test_the_schema_admits_what_the_code_admits() -> None:
    """Code and schema agree on each answer, except on numbers and sizes, which only the problem decides."""
    sys.path.insert(0, str(HERE))
    try:
        import odd_program
    finally:
        sys.path.remove(str(HERE))
    problem = {"number": 1, "start": [2.0, 0.0], "times": [0.0] * 64}
    by_problem = {"other number", "few states", "many states", "wide state", "two lines", "no counts"}
    ways = [
        "garbage", "list", "plain nan", "true number", "no status", "odd status", "no states", "true state",
        "text state",
    ]  # fmt: skip
    ways += [
        "odd hex", "odd steps", "huge steps", "half steps", "no reason", "lacks nothing", "encoded", "stopped", "refused", "fine",
    ]  # fmt: skip
    for way in ways + sorted(by_problem - {"two lines"}):
        line = odd_program.answers(way, problem)
        if way in by_problem:
            assert valid(line, "reply"), way
        elif way != "plain nan":  # Python's own reader takes a bare NaN
            assert valid(line, "reply") == admitted(line), way
    for way, described in odd_program.DESCRIPTIONS.items():
        if described is not None and way not in ("no counts", "odd name", "nan", "huge step"):
            assert not valid(json.dumps(described), "description"), way
    assert valid(json.dumps(odd_program.DESCRIPTION), "description")
    assert valid(protocol.describe_line(), "request")
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


def test_a_worker_gets_the_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From any working folder, and as a user's own; a change of the program is another version."""
    script = tmp_path / "mine.py"
    script.write_text((HERE / "odd_program.py").read_text())
    monkeypatch.chdir(tmp_path)
    integrator = from_command([sys.executable, "mine.py", "fine"])
    monkeypatch.chdir("/")
    again = references.dereference(references.reference(integrator))
    assert again.id == integrator.id == "command:odd"
    assert lookup.is_users_own(again)
    assert solved(again).steps == 64
    before = integrator.versions()
    script.write_text(script.read_text() + "\n# edited\n")
    assert integrator.versions() != before


def test_a_program_is_verified_on_the_cases_that_it_knows(rk4: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It gets the name of the case as in a run; a case that it lacks counts as nothing."""
    named = ("verify", "--command", str(rk4), "--depth", "low", "--claim", "step_order")
    assert gnomon(*named, "--case", "pendulum_simple") == 0
    assert "1 claims checked on 1 cases, 1 passed" in capsys.readouterr().out
    assert gnomon("verify", "--command", str(rk4), "--depth", "low", "--case", "duffing_unforced") == 2
    assert "0 claims checked" in capsys.readouterr().out


DESCRIBED = {
    "protocol": 1, "name": "mine", "order": 4, "sweep": {"kind": "step", "coarsest": 0.5, "halvings": 8},
    "forms": ["FirstOrder"], "counts_rhs": True, "sampling": "grid", "conserves": ["energy"], "jacobian": "exact",
}  # fmt: skip
TOLERANCES = {"kind": "tolerance", "loosest": 1e-2, "tightest": 1e-12, "per_decade": 1}
ODD = [
    None,
    True,
    False,
    0,
    1,
    1.0,
    1.5,
    -1,
    61,
    1001,
    1e999,
    "",
    "a",
    "exact",
    [],
    ["FirstOrder"],
    [1],
    {},
    {"kind": "step"},
]


@pytest.mark.parametrize("sweep", [DESCRIBED["sweep"], TOLERANCES])
def test_a_description_is_admitted_as_the_schema_says(sweep: dict[str, Any]) -> None:
    """Every key with every odd value, and without it: the code validates without the library of JSON Schema."""
    whole = DESCRIBED | {"sweep": sweep}
    found = [whole | {name: value} for name in DESCRIBED for value in ODD]
    found += [whole | {"sweep": sweep | {name: value}} for name in sweep for value in ODD]
    found += [{name: value for name, value in whole.items() if name != left} for left in whole]
    lines = [json.dumps(each).replace("Infinity", "1e999") for each in found]
    admitted = [described(line) for line in lines]
    assert admitted == [valid(line, "description") for line in lines]
    assert 0 < sum(admitted) < len(lines)


def described(line: str) -> bool:
    try:
        protocol.description(line)
    except Unusable:
        return False
    return True
