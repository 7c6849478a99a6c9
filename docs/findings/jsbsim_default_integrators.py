"""JSBSim: the default integrators are not those that the class documentation of FGPropagate names.

Its constructor is said to set Adams-Bashforth 2 for both rates and the trapezoidal method for both positions.
"""

import jsbsim

logger = jsbsim.DefaultLogger()
logger.set_min_level(jsbsim.LogLevel.FATAL)
jsbsim.set_logger(logger)
NAMES = {
    0: "none",
    1: "Euler",
    2: "trapezoidal",
    3: "Adams-Bashforth 2",
    4: "Adams-Bashforth 3",
    5: "Adams-Bashforth 4",
}
SAID = {"rate/rotational": 3, "rate/translational": 3, "position/rotational": 2, "position/translational": 2}

fdm = jsbsim.FGFDMExec(None, None)
found = {name: int(fdm[f"simulation/integrator/{name}"]) for name in SAID}
for name, number in found.items():
    print(f"{name}: {NAMES[number]}; said to be {NAMES[SAID[name]]}")
assert found == dict(zip(SAID, (1, 3, 1, 4), strict=True)), "the defaults have changed"
