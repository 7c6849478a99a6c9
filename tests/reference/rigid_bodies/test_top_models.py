"""The simpler models of the heavy top against derivatives of its own equations."""

import mpmath
from gnomon.cases import get
from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.rigid_bodies.lagrange_top import top_equations


def test_the_small_nutation_is_the_first_order_of_the_tops_equations():
    case = get("lagrange_top_small_nutation", tilt="0.7")
    with mpmath.workdps(40):
        equations = rebind(top_equations, {"sin": mpmath.sin, "cos": mpmath.cos})
        numbers = tuple(mpmath.mpf(x.numerator) / x.denominator for x in case.parameter_values()[:5])
        found = [mpmath.mpf(x.mid().str(38, radius=False)) for x in case.exact_motion.rates()]
        for place, component in enumerate((1, 2, 3)):

            def rate(theta, component=component):
                return equations(0, (theta, 0, 0, 0), numbers)[component]

            assert abs(found[2 * place] - rate(mpmath.mpf("0.7"))) < 1e-12 * abs(found[2 * place])
            assert abs(found[2 * place + 1] - mpmath.diff(rate, mpmath.mpf("0.7"))) < 1e-12 * abs(found[2 * place + 1])


def test_each_level_of_the_hierarchy_is_closer_to_the_top():
    """Without nutation, in regular precession, the error of the linear model is 1e-8 squared."""
    top = get("lagrange_top", "regular").rounded()
    steady, small = top.hierarchy
    errors = [
        float(top.metric.distance(r.project(r.case.sample(top.times)), top.sample(top.times)).max())
        for r in (steady, small)
    ]
    assert errors[1] < 1e-6 < errors[0]
