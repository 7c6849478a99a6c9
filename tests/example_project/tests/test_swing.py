from swing.verified import verlet

import gnomon.verify


@gnomon.verify.parametrize(verlet, cases=["pendulum_simple"], known_failures="known_failures.txt")
def test_claims(check):
    check()


def test_a_swing():
    gnomon.verify.assert_follows(verlet, "pendulum_simple", 0.001, within=1e-4)
