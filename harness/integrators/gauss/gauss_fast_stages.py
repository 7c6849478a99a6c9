"""The stages of one step of the fast Gauss method, as text: fixed-point iteration, accelerated by derivatives.

The iteration solves f = f(t + c h, y + h A f), or a = a(t + c h, q + h c v + h^2 A^2 a). Each component has one vector,
with the eight stages in its eight lanes. See `lane_text` for the notation.
"""

from __future__ import annotations

from gnomon.harness.integrators.gauss.lane_text import LaneText
from gnomon.harness.kernels.traced import reached


class CommonText(LaneText):
    """The parts of the text that single trajectories and ensembles share."""

    def signature(self) -> str:
        """The types of `p_, table, initial, times, tolerance, out` and of the integers that the function writes."""
        return "float64[::1], float64[:, ::1], float64[:, ::1], float64[::1], float64, float64[:, :, ::1], int64[::1]"

    def placed(self) -> str:
        """The arguments of the equations at the stages: places x, velocities u."""
        return "<|x@, |><|u@, |>" if self.layout.with_velocity else "<|x@, |>"

    def rate(self) -> str:
        """The quantity whose time derivatives the slopes are: the velocity, or the state of first-order equations."""
        return "y[&]" if self.layout.second_order else "y[@]"

    def first_step(self) -> str:
        """The first step: a share of the time |y| / |y'|, or |v| / |a| + |q / a|^(1/2)."""
        return """
            first_step = FIRST_AT_REST * end
            if fastest > 0.0 and largest > 0.0:  #? first_order
                first_step = FIRST_SHARE * largest / fastest
            if fastest > 0.0 and furthest + largest > 0.0:  #? second_order
                first_step = FIRST_SHARE * (largest / fastest + np.sqrt(furthest / fastest))
            first_step = min(first_step, end)
        """

    def convergence(self) -> str:
        """Decide whether the rounds end. A change d at the rate r leaves an error of d r / (1 - r), here taken as d r.

        The next round may converge far more slowly than this one, so r is at least `assumed_rate`. Changes at the level
        of round-off do not shrink. `rounds` becomes negative if the iteration does not converge.
        """
        return """
            if change * max(rate, assumed_rate) <= allowed_change and rate < SLOW:
                break
            if change < noise and (rate > SLOW or rounds > MANY):
                break
            if not change < MOST_CHANGE or rounds == MOST_ROUNDS or (rounds > SETTLING and rate > SLOW):
                rounds = -rounds
                break
        """


class StagesText(CommonText):
    """The text of the iteration for single trajectories: `stages` for steps, `aside` for samples."""

    def stages(self) -> str:
        """The iteration of a step, which also gives the fourth power of the frequency at the end of the step.

        This is the square of the Frobenius norm of J, the derivatives of accelerations by positions; 0 if J is not
        known. The stage polynomial extrapolates it to the end of the step. As that may be inaccurate, the value at the
        last stage limits it.
        """
        return """
            @njit(forceinline=True, {inner})
            def stages({given}):
                {iteration}
                squares = lanes({sum_of_squares})  #? by_position
                at_end = max(total(row(table, ENDS) * squares), lane(squares, 7) / MOST_SQUARE_CHANGE)  #? by_position
                square = min(at_end, MOST_SQUARE_CHANGE * lane(squares, 7))  #? by_position
                square = 0.0  #? not by_position
                return {found}, square
        """

    def aside(self) -> str:
        """The iteration of a sample, in a function that is not inlined: that would double the time of compilation."""
        return """
            @njit({inner})
            def aside({given}):
                {iteration}
                return {found}, 0.0
        """

    def sum_of_squares(self) -> str:
        return " + ".join(f"g[{n}] * g[{n}]" for n in self.layout.by_position)

    def given(self) -> str:
        """The arguments of the iteration.

        f: guesses of the slopes; p and v: their sums. `unmonitored`: number of the first rounds, whose changes are not
        computed; `expected`: the rate of the round after them, 0 if unknown.
        """
        return (
            "t, h, y, compensation, f, p, v, k, table, change_weight, allowed_change, noise, assumed_rate, expected, "
            "unmonitored, exactly"
        )

    def found(self) -> str:
        """The results: rounds, rate of convergence, slopes. The rate is 0 if the changes are round-off."""
        return "rounds, rate if before > noise else 0.0, (<|f@, |>)"

    def iteration(self) -> str:
        """Repeat rounds until the expected change of the next round is allowed.

        Changes are sums over all stages and components. All rounds use b = q + h c v, with c in two parts, and its
        rounding residual e.
        """
        return """
            <|f@, |> = f
            hh = lanes(h)
            w = forcing(fma(hh, row(table, NODES), lanes(t)), k)
            m, n = hh * row(table, NODES_HIGH), hh * row(table, NODES_LOW)  #? second_order
            b@ = fma(m, lanes(y[&]), fma(n, lanes(y[&]), lanes(y[@])))  #? second_order
            e@ = lanes(0.0)  #? second_order
            if exactly:  #? second_order
                e@ = fma(n, lanes(y[&]), fma(m, lanes(y[&]), lanes(y[@]) - b@)) + lanes(compensation[@])
            {places}  #? groups
            before, rate, rounds = 0.0, expected, 0
            while True:
                {round_by_groups}  #? groups
                {round_of_all}  #? not groups
                rounds += 1
                if rounds > unmonitored:
                    off = lanes(0.0)
                    off = fma(size(g@ - f@), lanes(change_weight[@]), off)
                    change = total(off)
                    if rounds > unmonitored + 1:
                        rate = change / before if before > 0.0 else 0.0
                    if rounds > unmonitored + 1 or expected > 0.0 or (unmonitored > 0 and change <= allowed_change):
                        f@ = g@
                        {convergence}
                    before = change
                f@ = g@
                {places_of_last_group}  #? groups
                p, v = sums((<|f@, |>), table, STAGES, ONCE)  #? not groups
        """

    def sums(self) -> str:
        """A f, or A^2 a, and A a if the equations need velocities. `first` and `once`: first rows of the matrices."""
        return """
            @njit(forceinline=True, {inner})
            def sums(f, table, first, once):
                <|f@, |> = f
                p = products(table, first, (<|f@, |>))
                return p, p  #? not with_velocity
                return p, products(table, once, (<|f@, |>))  #? with_velocity
        """

    def places(self) -> str:
        return """
            x@ = fma(hh, p[@], lanes(y[@]))  #? first_order
            x@ = fma(hh * hh, p[@], b@)  #? second_order
            u@ = fma(hh, v[@], lanes(y[&]))  #? with_velocity
        """

    def round_of_all(self) -> str:
        """A round of all slopes: the new slopes g.

        Sine and cosine come from their values at the nearby angle of the round before. With derivatives J the new
        slopes are g + J h A (g - f), as the changes of the round predict, plus J s with the rounding residuals s of the
        places.
        """
        return """
            {places}
            g = slopes(({placed}), w, k)  #? not turns
            if rounds == 0:  #? turns
                g, near = slopes_first(({placed}), w, k)
            else:  #? turns
                g, near = slopes_again(({placed}), w, k, near)
            {corrections}
        """

    def corrections(self) -> str:
        """The corrections by derivatives. Terms without products come first, so that little waits for the products."""
        if not self.layout.derivatives:
            return "g@ = lanes(g[@])"
        lines = ["d@ = lanes(g[@]) - f@", "q = products(table, STAGES, (<|d@, |>))"]
        lines += ["r = products(table, ONCE, (<|d@, |>))  #? with_velocity", "g@ = lanes(g[@])"]
        lines += ["if exactly:  #? second_order", "    s@ = fma(hh * hh, p[@], b@ - x@) + e@"]
        late = []
        for n, (i, j, _value) in enumerate(self.layout.derivatives, self.layout.count):
            step, moves = ("hh", "r") if self.layout.second_order else ("hh", "q")
            if n in self.layout.by_position:
                step, moves = "hh * hh", "q"
                lines.append(f"    g{i} = fma(lanes(g[{n}]), s{j}, g{i})")
            late.append(f"g{i} = fma(lanes(g[{n}]) * ({step}), {moves}[{j % self.layout.count}], g{i})")
        return "\n".join(lines + late)

    def round_by_groups(self) -> str:
        """A round by groups, for many first-order equations: each group uses the new slopes of the groups before it.

        This is Gauss-Seidel iteration: a pair x' = v, v' = -x converges with the square of the rate.
        """
        lines = []
        for n, group in enumerate(self.layout.groups):
            lines += [f"g = slopes_{n}((<|x@, |>), w, k)", *(f"g{i} = g[{k}]" for k, i in enumerate(group))]
            lines += self.places_of(group) if n < len(self.layout.groups) - 1 else []
        return "\n".join(lines)

    def places_of_last_group(self) -> str:
        return "\n".join(self.places_of(self.layout.groups[-1]))

    def places_of(self, group: tuple[int, ...]) -> list[str]:
        """Lines that compute places from the new slopes of a group; places on which no slope depends are left out."""
        read = {x.operation for x in reached(self.layout.values)}
        places = [i for i in group if f"y[{i}]" in read]
        lines = [f"p = products(table, STAGES, ({', '.join(f'g{i}' for i in places)}, ))"] if places else []
        return lines + [f"x{i} = fma(hh, p[{k}], lanes(y[{i}]))" for k, i in enumerate(places)]
