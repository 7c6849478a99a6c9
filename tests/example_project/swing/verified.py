"""Declarations of the integrators of this package, for gnomon alone."""

from gnomon.verify import from_step
from swing import step

verlet = from_step(
    step, name="Verlet", order=2, conserves=("symplectic", "reversible"), accelerations=True, library="swing"
)
