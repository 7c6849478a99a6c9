"""Newton: SolverFeatherstone stores its `angular_damping` and never reads it.

A ball turns freely at 1 rad/s for 1 s, at any value of the argument, whose default is 0.05.
"""

import warp

warp.config.log_level = warp.LOG_ERROR
import newton  # noqa: E402

DT, STEPS = 1e-2, 100


def rate(damping):
    """The rate (rad/s) of the ball after 1 s."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    body = builder.add_body(mass=1.0, inertia=warp.mat33(1, 0, 0, 0, 1, 0, 0, 0, 1))
    model = builder.finalize(device="cpu")
    solver = newton.solvers.SolverFeatherstone(model, angular_damping=damping)
    now, after = model.state(), model.state()
    now.joint_qd.assign([0, 0, 0, 0, 0, 1])
    newton.eval_fk(model, now.joint_q, now.joint_qd, now)
    for _ in range(STEPS):
        now.clear_forces()
        solver.step(now, after, model.control(), None, DT)
        now, after = after, now
    return float(now.body_qd.numpy()[body][5])


found = {damping: rate(damping) for damping in (0.0, 0.05, 5.0)}
for damping, after in found.items():
    print(f"angular_damping={damping:g}: after 1 s at 1 rad/s the rate is {after:g} rad/s")
assert set(found.values()) == {1.0}, "the damping now acts"
