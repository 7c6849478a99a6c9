"""The stages of one step of the fast Gauss method, as text: fixed-point iteration, accelerated by derivatives.

f = f(t + c h, y + h A f), or a = a(t + c h, q + h c v + h^2 A^2 a), for all eight stages in the eight lanes of a vector; one
vector for each component. See `lane_text` for the notation.
"""

from __future__ import annotations

from gnomon.harness.integrators.gauss.lane_text import LaneText
from gnomon.harness.kernels.traced import reached


class CommonText(LaneText):
    """What single trajectories and ensembles have in common."""

    def signature(self) -> str:
        """Of `p_, table, initial, times, tolerance, out` and the integers that the function gives beside `out`."""
        return "float64[::1], float64[:, ::1], float64[:, ::1], float64[::1], float64, float64[:, :, ::1], int64[::1]"

    def placed(self) -> str:
        """The arguments of the equations at the stages: places x, velocities u."""
        return "<|x@, |><|u@, |>" if self.layout.with_velocity else "<|x@, |>"

    def rate(self) -> str:
        """What changes by the slopes: the velocity, or the state."""
        return "y[&]" if self.layout.second_order else "y[@]"

    def first_step(self) -> str:
        """A share of the times |y| / |y'|, or |v| / |a| + |q / a|^(1/2)."""
        return """
            first_step = FIRST_AT_REST * end
            if fastest > 0.0 and largest > 0.0:  #? first_order
                first_step = FIRST_SHARE * largest / fastest
            if fastest > 0.0 and furthest + largest > 0.0:  #? second_order
                first_step = FIRST_SHARE * (largest / fastest + np.sqrt(furthest / fastest))
            first_step = min(first_step, end)
        """

    def convergence(self) -> str:
        """Whether the rounds end. For a rate r the change d leaves an error of d r / (1 - r), here d r.

        The rate of one round may be far better than that of the next, so `assumed_rate` is the least. Changes at the level
        of round-off do not shrink. `rounds` is made negative where the iteration does not converge.
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
    """The iteration of single trajectories: `stages` for steps, `aside` for samples."""

    def stages(self) -> str:
        """The iteration of a step. It also gives the fourth power of the frequency of the motion at the end of the step, 0
        where that is not known: the square of the norm of Frobenius of J, the derivatives of accelerations by positions.

        It is continued to the end of the step by the stage polynomial. That may be inaccurate, so it is limited by the
        value at the last stage.
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
        """The same for a sample, as a function of its own: inlined twice, it would take twice as long to compile."""
        return """
            @njit({inner})
            def aside({given}):
                {iteration}
                return {found}, 0.0
        """

    def sum_of_squares(self) -> str:
        return " + ".join(f"g[{n}] * g[{n}]" for n in self.layout.by_position)

    def given(self) -> str:
        """Of the step: f, the guesses of the slopes; p and v, their sums. Of the iteration: `unmonitored`, rounds whose
        changes are not computed; `expected`, the rate of the first of the others, 0 where none is known."""
        return (
            "t, h, y, compensation, f, p, v, k, table, change_weight, allowed_change, noise, assumed_rate, expected, "
            "unmonitored, exactly"
        )

    def found(self) -> str:
        """Rounds, the rate of convergence, slopes. Changes that are round-off give no rate."""
        return "rounds, rate if before > noise else 0.0, (<|f@, |>)"

    def iteration(self) -> str:
        """Rounds until the change expected in the next one is allowed. Changes are sums over all stages and components.

        The stages have b = q + h c v in common, with c in two parts, and its rounding residual e.
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
        """A f, or A^2 a; and A a, where the equations need velocities. `first` and `once`: rows of the matrices."""
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
        """The new slopes g. Sine and cosine of an angle come from those of the round before, nearly at the same angle.

        With derivatives J: g + J h A (g - f), the change of the slopes that the changes of the round predict. To it belongs
        J s, where s is what the rounding of the places left out.
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
        """Terms that are known before the products are multiplied first, so that little waits for the products."""
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
        """Many first-order equations: each group of slopes with the new ones of the groups before it (Gauss-Seidel).

        A pair x' = v, v' = -x converges with the square of the rate.
        """
        lines = []
        for n, group in enumerate(self.layout.groups):
            lines += [f"g = slopes_{n}((<|x@, |>), w, k)", *(f"g{i} = g[{k}]" for k, i in enumerate(group))]
            lines += self.places_of(group) if n < len(self.layout.groups) - 1 else []
        return "\n".join(lines)

    def places_of_last_group(self) -> str:
        return "\n".join(self.places_of(self.layout.groups[-1]))

    def places_of(self, group: tuple[int, ...]) -> list[str]:
        """Lines that compute places from the new slopes of a group, as far as any slope depends on them."""
        read = {x.operation for x in reached(self.layout.values)}
        places = [i for i in group if f"y[{i}]" in read]
        lines = [f"p = products(table, STAGES, ({', '.join(f'g{i}' for i in places)}, ))"] if places else []
        return lines + [f"x{i} = fma(hh, p[{k}], lanes(y[{i}]))" for k, i in enumerate(places)]
