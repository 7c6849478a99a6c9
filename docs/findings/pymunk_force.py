"""pymunk: a force that depends on the position and is set before each step adds energy: the step is Euler's explicit one.

`Space.step` first moves bodies with their velocities, then adds forces to the velocities. A force that was set before the
step belongs to the position before the move. In `velocity_func`, which is called after the move, the same force adds none.
"""

import math

import pymunk

PERIODS = 10


def energy(dt, during):
    """The energy of an oscillator of 1 kg and 1 N/m after ten periods, over its initial energy."""
    space, body = pymunk.Space(), pymunk.Body(1, 1)
    body.position = 1, 0
    space.add(body)

    def pull(body, gravity, damping, dt):
        body.force = -body.position
        pymunk.Body.update_velocity(body, gravity, damping, dt)

    if during:
        body.velocity_func = pull
    for _ in range(round(2 * math.pi * PERIODS / dt)):
        if not during:
            body.force = -body.position
        space.step(dt)
    return body.position.length**2 + body.velocity.length**2


for dt in (1e-1, 1e-2):
    before, during = energy(dt, during=False), energy(dt, during=True)
    print(
        f"step {dt:g} s, energy after {PERIODS} periods over the first: {before:.3g} set before, {during:.4g} in velocity_func"
    )
    explicit = (1 + dt * dt) ** round(2 * math.pi * PERIODS / dt)
    assert abs(before / explicit - 1) < 1e-6, "it is no longer Euler's explicit step"
    assert abs(during - 1) < dt
