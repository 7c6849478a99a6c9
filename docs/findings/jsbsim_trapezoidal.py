"""JSBSim: the "trapezoidal" integrator has order 1, and twice the error of Euler's method.

A free body with moments 1, 1 and 2 turns; its rates about the two equal axes are a cosine and a sine of the time.
The method averages the last two derivatives, so it uses the derivative of half a step before the present one.
"""

import math
import tempfile
from pathlib import Path

import jsbsim

logger = jsbsim.DefaultLogger()
logger.set_min_level(jsbsim.LogLevel.FATAL)
jsbsim.set_logger(logger)
BODY = """<?xml version="1.0"?><fdm_config name="body" version="2.0" release="BETA"><fileheader/>
<metrics><wingarea unit="FT2">1</wingarea><wingspan unit="FT">1</wingspan><chord unit="FT">1</chord>
<location name="AERORP" unit="FT"><x>0</x><y>0</y><z>0</z></location></metrics>
<mass_balance><ixx unit="SLUG*FT2">1</ixx><iyy unit="SLUG*FT2">1</iyy><izz unit="SLUG*FT2">2</izz>
<emptywt unit="LBS">32</emptywt><location name="CG" unit="FT"><x>0</x><y>0</y><z>0</z></location></mass_balance>
<ground_reactions/><propulsion/><external_reactions/><aerodynamics/></fdm_config>"""
PLANET = """<?xml version="1.0"?><planet name="sphere"><GM unit="FT3/SEC2">0</GM><semimajor_axis unit="FT">1e6</semimajor_axis>
<semiminor_axis unit="FT">1e6</semiminor_axis><rotation_rate unit="RAD/SEC">0</rotation_rate><J2>0</J2></planet>"""


def error(method, dt):
    """The error of the rates (rad/s) after 1 s; they turn at 1 rad/s and have the size 1 rad/s."""
    with tempfile.TemporaryDirectory() as folder:
        (place := Path(folder, "aircraft", "body")).mkdir(parents=True)
        (place / "body.xml").write_text(BODY)
        (planet := Path(folder, "planet.xml")).write_text(PLANET)
        fdm = jsbsim.FGFDMExec(folder, None)
        fdm.set_debug_level(0)
        fdm.load_planet(str(planet), False)
        fdm.load_model("body")
    fdm.set_dt(dt)
    fdm["simulation/integrator/rate/rotational"] = method
    fdm["ic/p-rad_sec"], fdm["ic/r-rad_sec"], fdm["ic/h-sl-ft"] = 1.0, 1.0, 1e3
    fdm.run_ic()
    for _ in range(round(1 / dt)):
        fdm.run()
    return math.hypot(fdm["velocities/pi-rad_sec"] - math.cos(1), fdm["velocities/qi-rad_sec"] - math.sin(1))


STEPS = (1e-2, 1e-3, 1e-4)
found = {name: [error(number, dt) for dt in STEPS] for name, number in (("Euler", 1), ("trapezoidal", 2), ("AB2", 3))}
for name, errors in found.items():
    print(f"{name}: error after 1 s {', '.join(f'{each:.2e}' for each in errors)} rad/s at steps of 1e-2, 1e-3, 1e-4 s")
ratios = [a / b for a, b in zip(found["trapezoidal"], found["Euler"], strict=True)]
assert all(1.9 < ratio < 2.1 for ratio in ratios), "the error is no longer twice that of Euler's method"
assert 9 < found["trapezoidal"][0] / found["trapezoidal"][1] < 11, "its order is no longer 1"
