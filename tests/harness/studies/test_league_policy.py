"""The league finds the engines with a tighter solver by the policy that their adapters write."""

from gnomon.harness.adapters.engines.scene_run import TIGHTER
from gnomon.harness.registry import lookup
from gnomon.harness.studies import league


def test_the_league_and_the_adapters_name_the_policy_alike() -> None:
    assert league.TIGHT == TIGHTER
    tight = [one for one in lookup.own().values() if getattr(one, "tight", False)]
    assert {"pybullet", "mujoco", "pymunk"} <= {one.library for one in tight}
    assert all(one.policy == league.TIGHT for one in tight)
    assert not [one for one in league.choose_shown(tight)]
