"""JSBSim: a mass that is given in slugs is 2.15e-7 too small.

A slug is read as 14.59390 kg of 1/0.45359237 lb each, and pounds become slugs by 1/32.174049. The product is not 1.
"""

import tempfile
from pathlib import Path

import jsbsim

logger = jsbsim.DefaultLogger()
logger.set_min_level(jsbsim.LogLevel.FATAL)
jsbsim.set_logger(logger)
BODY = """<?xml version="1.0"?><fdm_config name="body" version="2.0" release="BETA"><fileheader/>
<metrics><wingarea unit="FT2">1</wingarea><wingspan unit="FT">1</wingspan><chord unit="FT">1</chord>
<location name="AERORP" unit="FT"><x>0</x><y>0</y><z>0</z></location></metrics>
<mass_balance><ixx unit="SLUG*FT2">1</ixx><iyy unit="SLUG*FT2">1</iyy><izz unit="SLUG*FT2">1</izz>
<emptywt unit="{}">{}</emptywt><location name="CG" unit="FT"><x>0</x><y>0</y><z>0</z></location></mass_balance>
<ground_reactions/><propulsion/><external_reactions/><aerodynamics/></fdm_config>"""


def mass(unit, value):
    """The mass (slugs) of a body whose file gives it in this unit."""
    with tempfile.TemporaryDirectory() as folder:
        (place := Path(folder, "aircraft", "body")).mkdir(parents=True)
        (place / "body.xml").write_text(BODY.format(unit, value))
        fdm = jsbsim.FGFDMExec(folder, None)
        fdm.set_debug_level(0)
        fdm.load_model("body")
        fdm.run_ic()
        return fdm["inertia/mass-slugs"]


slug, pounds = mass("SLUG", 1.0), mass("LBS", 32.174049)
print(f"1 slug is loaded as {slug:.10f} slug, 32.174049 lbs as {pounds:.10f} slug")
assert abs(pounds - 1) < 1e-12
assert abs(slug - 1 + 2.15e-7) < 1e-9, "the two units now agree"
