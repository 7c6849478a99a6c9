"""The registry of cases and checks by name. Modules are imported on first use: listing names imports none."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from importlib.metadata import entry_points

from gnomon.cases.core.case import Case
from gnomon.cases.core.check import Check
from gnomon.cases.core.numbers import nearest
from gnomon.reference.numerics.precision import Number
from gnomon.reference.storage.importing import confined

_MODULES = {
    "pendulum_simple": "pendulums.pendulum_simple:PendulumSimple",
    "harmonic_oscillator": "oscillators.harmonic_oscillator:HarmonicOscillator",
    "duffing_unforced": "oscillators.duffing_unforced:DuffingUnforced",
    "damped_oscillator": "oscillators.damped_oscillator:DampedOscillator",
    "cycloidal_pendulum": "pendulums.cycloidal_pendulum:CycloidalPendulum",
    "kepler_orbit": "orbits.kepler_orbit:KeplerOrbit",
    "euler_top": "rigid_bodies.euler_top:EulerTopCase",
    "foucault_pendulum_linear": "pendulums.foucault_pendulum_linear:FoucaultLinear",
    "foucault_precession": "pendulums.foucault_pendulum_linear:FoucaultPrecession",
    "projectile_parabola": "flight.projectile_parabola:ProjectileParabola",
    "projectile_stokes_drag": "flight.projectile_stokes_drag:ProjectileStokesDrag",
    "projectile_quadratic_drag": "flight.quadratic_drag:ProjectileQuadraticDrag",
    "pendulum_quadratic_damping": "pendulums.pendulum_quadratic_damping:PendulumQuadraticDamping",
    "vertical_quadratic_drag": "flight.quadratic_drag:VerticalQuadraticDrag",
    "ink_jet_printer": "flight.droplets:InkJetPrinter",
    "millikan_oil_drop": "flight.droplets:MillikanOilDrop",
    "charge_in_E_and_B": "flight.charges:ChargeInFields",
    "relativistic_charge": "flight.charges:RelativisticChargeCase",
    "forced_oscillator": "oscillators.forced_oscillators:ForcedOscillator",
    "second_order_linear_ode": "oscillators.forced_oscillators:SecondOrderLinearOde",
    "time_varying_force": "oscillators.forced_oscillators:TimeVaryingForce",
    "inertial_straight_line": "rotating_frames.free_falls_rotating:InertialStraightLine",
    "planet_tunnel": "rotating_frames.planet_tunnel:PlanetTunnelCase",
    "planet_tunnel_rotating": "rotating_frames.planet_tunnel_rotating:PlanetTunnelRotating",
    "radial_fall_inverse_square": "orbits.radial_fall_inverse_square:RadialFallInverseSquare",
    "free_fall_first_order": "rotating_frames.free_falls_rotating:FreeFallFirstOrder",
    "free_fall_rotating_earth": "rotating_frames.free_falls_rotating:FreeFallRotatingEarth",
    "free_fall_rotating_frame_centrifugal": "rotating_frames.free_falls_rotating:FreeFallCentrifugal",
    "tower_drop": "rotating_frames.tower_drop:TowerFall",
    "foucault_pendulum_nonlinear": "pendulums.foucault_pendulum_nonlinear:FoucaultNonlinear",
    "bouncing_ball": "contact.bouncing_ball:BouncingBall",
    "block_incline_friction": "contact.block_incline_friction:BlockInclineFriction",
    "coulomb_friction_oscillator": "contact.coulomb_friction_oscillator:CoulombFrictionOscillator",
    "stick_slip_belt": "contact.stick_slip_belt:StickSlipBelt",
    "torpedo_firing_pin": "contact.torpedo_firing_pin:TorpedoFiringPin",
    "sliding_can": "contact.sliding_can:SlidingCanCase",
    "rotating_pendulum": "guided.pendulum_on_hoop:RotatingPendulum",
    "rotating_pendulum_free_hoop": "guided.pendulum_on_free_hoop:RotatingPendulumFreeHoop",
    "rotating_pendulum_swept": "guided.pendulum_on_free_hoop:RotatingPendulumSwept",
    "bearing_reaction_torque_stability": "guided.pendulum_on_hoop:BearingReactionTorqueStability",
    "gyrocompass": "rigid_bodies.gyrocompass:Gyrocompass",
    "small_vibrations_3dof_chain": "oscillators.small_vibrations:SmallVibrationsChain",
    "small_vibrations_mdof": "oscillators.small_vibrations:SmallVibrations",
    "bead_rotating_wire_vertical_plane": "guided.bead_rotating_wire_vertical_plane:BeadOnRotatingWire",
    "projectile_parabolic_coordinates": "flight.projectile_parabolic_coordinates:ProjectileInParabolicCoordinates",
    "rayleigh_dissipation_mdof": "oscillators.rayleigh_dissipation_mdof:RayleighDissipation",
    "two_body": "orbits.two_body:TwoBody",
    "equilateral_three_body": "orbits.equilateral_three_body:EquilateralThreeBody",
    "chain_off_table": "guided.chains_over_edge:ChainOffTable",
    "chain_quarter_circle": "guided.chain_quarter_circle:ChainQuarterCircle",
    "chain_over_pulley": "guided.chains_over_edge:ChainOverPulley",
    "chain_in_circular_tube": "pendulums.equivalent_pendulum:ChainInCircularTube",
    "moment_of_momentum_pendulum": "pendulums.equivalent_pendulum:MomentOfMomentumPendulum",
    "impulse_instantaneous": "flight.impulse_instantaneous:ImpulseInstantaneous",
    "ballistic_pendulum": "contact.ballistic_pendulum:BallisticPendulumCase",
    "torque_impulse_on_arm": "rigid_bodies.torque_impulse_on_arm:TorqueImpulseOnArm",
    "restitution_impact_1d_2d": "contact.restitution_impact_1d_2d:RestitutionImpact",
    "three_ball_chain": "contact.ball_line:ThreeBallChain",
    "newtons_cradle": "contact.ball_line:NewtonsCradle",
    "oblique_impact": "contact.oblique_impact:ObliqueImpact",
    "work_energy_spring_block": "oscillators.work_energy_spring_block:WorkEnergySpringBlock",
    "bead_leaving_sphere": "guided.contact_loss:BeadLeavingSphere",
    "amusement_park": "guided.contact_loss:AmusementPark",
    "pendulum_on_string": "guided.contact_loss:PendulumOnString",
    "rubber_tube_thin": "oscillators.rubber_tube:RubberTubeThin",
    "rubber_tube_thick": "oscillators.rubber_tube:RubberTubeThick",
    "slider_rotating_slot": "guided.slider_rotating_slot:SliderRotatingSlot",
    "chain_smooth_curve": "guided.chain_smooth_curve:ChainSmoothCurve",
    "curve_sliding_small": "guided.curve_sliding:CurveSlidingSmall",
    "curve_sliding_quartic": "guided.curve_sliding:CurveSlidingQuartic",
    "curve_sliding_catenary": "guided.curve_sliding:CurveSlidingCatenary",
    "central_force_conservation": "orbits.central_force:CentralForceConservation",
    "central_force_hanging_mass": "orbits.central_force:CentralForceHangingMass",
    "central_force_logarithmic": "orbits.central_force:CentralForceLogarithmic",
    "central_force_fifth_power": "orbits.central_force_fifth_power:CentralForceFifthPower",
    "central_force_shortened_string": "orbits.central_force_shortened_string:CentralForceShortenedString",
    "dumbbell_spring": "orbits.central_force:DumbbellSpring",
    "pendulum_on_cart": "pendulums.pendulum_on_cart:PendulumOnCart",
    "two_mass_spring": "orbits.two_masses:TwoMassSpring",
    "center_of_mass_motion": "orbits.two_masses:CenterOfMassMotion",
    "exploding_projectile": "contact.exploding_projectile:ExplodingProjectile",
    "man_on_cart": "contact.man_on_cart:ManOnCart",
    "dumbbell_free_flight": "orbits.two_masses:DumbbellFreeFlight",
    "atwood_pulley_systems": "flight.uniform_acceleration:AtwoodPulleySystems",
    "wedge_block_energy_momentum": "flight.uniform_acceleration:WedgeBlock",
    "lagrange_top": "rigid_bodies.lagrange_top:LagrangeTopCase",
    "lagrange_top_fast": "rigid_bodies.top_models:LagrangeTopFast",
    "lagrange_top_small_nutation": "rigid_bodies.top_models:LagrangeTopSmallNutation",
    "lagrange_top_attitude": "rigid_bodies.lagrange_top:LagrangeTopAttitude",
    "lagrange_top_sleeping_separatrix": "rigid_bodies.lagrange_top:LagrangeTopSleepingSeparatrix",
    "double_pendulum": "pendulums.double_pendulum:DoublePendulum",
    "spherical_pendulum": "pendulums.spherical_pendulum:SphericalPendulumCase",
    "symmetric_top_torque_free": "rigid_bodies.symmetric_top_torque_free:SymmetricTopTorqueFree",
    "rigid_body_stokes_medium_falling": "rigid_bodies.rigid_body_stokes_medium_loaded:RigidBodyStokesMediumFalling",
    "rigid_body_stokes_medium_torque": "rigid_bodies.rigid_body_stokes_medium_loaded:RigidBodyStokesMediumTorque",
    "rigid_body_stokes_medium": "rigid_bodies.rigid_body_stokes_medium:RigidBodyStokesMedium",
    "holonomic_constraint_dae": "pendulums.holonomic_constraint_dae:HolonomicConstraintDae",
    "billiard_ball_attitude": "contact.billiard_ball_spin:BilliardBallAttitude",
    "billiard_ball_drill": "contact.billiard_ball_spin:BilliardBallDrill",
    "billiard_ball": "contact.billiard_ball:BilliardBallCase",
    "spring_pendulum": "pendulums.spring_pendulum:SpringPendulum",
    "swinging_atwood": "pendulums.swinging_atwood:SwingingAtwood",
    "ignorable_coordinates": "guided.particles_on_surfaces:ParticleOnCone",
    "particle_on_paraboloid": "guided.particles_on_surfaces:ParticleOnParaboloid",
    "particle_on_torus": "guided.particles_on_surfaces:ParticleOnTorus",
    "sliding_ladder": "rigid_bodies.sliding_rods:SlidingLadderCase",
    "rigid_link_plane_motion": "rigid_bodies.sliding_rods:RigidLinkPlaneMotion",
    "foucault_pendulum_centrifugal": "pendulums.foucault_pendulum_centrifugal:FoucaultInPlaneCentrifugal",
    "bouncing_ball_incline": "contact.bouncing_ball_incline:BouncingBallIncline",
    "bouncing_ball_table": "contact.bouncing_ball_table:BouncingBallTable",
    "hanging_springs": "oscillators.hanging_springs:HangingSpringsCase",
    "chaplygin_sleigh": "rigid_bodies.nonholonomic:ChaplyginSleighCase",
    "knife_edge_incline": "rigid_bodies.nonholonomic:KnifeEdgeIncline",
    "rolling_disc": "rigid_bodies.rolling_disc:RollingDisc",
    "rotation_fixed_axis_compound_pendulum": "pendulums.compound_pendulum:CompoundPendulum",
    "rolling_sphere_in_bowl": "pendulums.compound_pendulum:RollingSphereInBowl",
    "dynamics_of_free_rigid_body_in_gravity": "rigid_bodies.dynamics_of_free_rigid_body_in_gravity:DynamicsOfFreeRigidBodyInGravity",
    "belt_driven_machine": "rigid_bodies.flywheels:BeltDrivenMachine",
    "flywheel": "rigid_bodies.flywheels:FlywheelCase",
    "flywheel_coast_down": "rigid_bodies.flywheels:FlywheelCoastDown",
    "engineering_design_analysis": "rigid_bodies.engineering_design_analysis:EngineeringDesignAnalysis",
    "gyrocompass_damped_nonlinear": "rigid_bodies.gyrocompass_nonlinear:GyrocompassDampedNonlinear",
    "gyrocompass_tilting": "rigid_bodies.gyrocompass_nonlinear:GyrocompassTilting",
    "gyrocompass_damped": "rigid_bodies.gyrocompass_damped:GyrocompassDamped",
    "rolling_bodies": "contact.rolling_bodies:RollingBodies",
    "yo_yo": "contact.rolling_bodies:YoYo",
}


_CHECKS = {
    "inertia_tensor_special_bodies": "checks.inertia:InertiaTensorSpecialBodies",
    "inertia_composite_parallel_axis": "checks.inertia:InertiaCompositeParallelAxis",
    "inertia_transformation_principal": "checks.inertia:InertiaTransformationPrincipal",
    "com_rigid_body": "checks.centres_and_moments:ComRigidBody",
    "moment_equipollent": "checks.centres_and_moments:MomentEquipollent",
    "gravity_field_particle_body": "checks.gravity:GravityFieldParticleBody",
    "weight_local_gravity": "checks.gravity:WeightLocalGravity",
    "falling_target": "checks.falling_target:FallingTarget",
    "apparent_gravity_earth": "checks.frames:ApparentGravityEarth",
    "frame_transformation": "checks.frames:FrameTransformation",
    "material_frame_indifference": "checks.frames:MaterialFrameIndifference",
    "work_constant_linear_coulomb": "checks.work_of_forces:WorkConstantLinearCoulomb",
    "conservative_force_test": "checks.work_of_forces:ConservativeForceTest",
    "hamilton_action": "checks.hamilton_action:HamiltonAction",
    "amusement_rides": "checks.amusement_rides:AmusementRides",
    "capstan_belt": "checks.capstan_belt:CapstanBelt",
    "rotor_dynamic_balance": "checks.rotors_and_impulses:RotorDynamicBalance",
    "work_energy_rigid_body": "checks.work_energy_rigid_body:WorkEnergyRigidBody",
    "generalized_impulse": "checks.rotors_and_impulses:GeneralizedImpulse",
    "projectile_coriolis_first_order": "checks.perturbation:ProjectileCoriolisFirstOrder",
    "falkland_gunnery": "checks.perturbation:FalklandGunnery",
    "stability_pendulum_linearisation": "checks.perturbation:StabilityPendulumLinearisation",
    "rod_tension_circular": "checks.particles:RodTensionCircular",
    "moment_momentum_moving_point": "checks.particles:MomentMomentumMovingPoint",
    "internal_potential_energy": "checks.particles:InternalPotentialEnergy",
}
"""The checks: rows of the catalogue without motion."""


def names() -> tuple[str, ...]:
    """The names of all cases (checks excluded), entry points of the group `gnomon.cases` included."""
    return (*_MODULES, *(point.name for point in entry_points(group="gnomon.cases")))


def case_class(name: str) -> type[Case]:
    """The class of a case by its name, or by `package.module:Class`.

    Raises ValueError for an unknown name, with the nearest valid ones.
    """
    if name in _MODULES:
        return load(f"gnomon.cases.{_MODULES[name]}")
    for point in entry_points(group="gnomon.cases"):
        if point.name == name:
            return load(point.value)
    if ":" in name:
        return load(name)
    raise ValueError(f"no case is named {name!r}; {nearest(name, names())}")


def installed_names() -> frozenset[str]:
    """The names of gnomon's cases and of those that installed packages declare: entry points `gnomon.cases`."""
    return frozenset(names()) | {point.name for point in entry_points(group="gnomon.cases")}


def load(path: str) -> type[Case]:
    """A case class from `package.module:Class`."""
    module, _, attribute = path.partition(":")
    try:
        with confined():
            return _checked(getattr(importlib.import_module(module), attribute), path)
    except BaseException as error:  # a user's module may raise anything while it is imported
        raise ValueError(
            f"{path}: {type(error).__name__}: {error}; give package.module:Class of a subclass of gnomon.cases.Case"
        ) from None


def _checked(found: object, path: str) -> type[Case]:
    if not (isinstance(found, type) and issubclass(found, Case)):
        raise ValueError(f"{path} is not a subclass of gnomon.cases.Case")
    return found


def get(
    name: str,
    variant: str | None = None,
    initial_state: Sequence[Number] | None = None,
    span: Number | None = None,
    **parameters: Number,
) -> Case:
    """A case with exact numbers (SI units). A variant's numbers are overridden by those given.

    Raises ValueError for an unknown name, variant or parameter and for numbers outside the domain.
    """
    return case_class(name)(variant, initial_state, span, **parameters)


def check_names() -> tuple[str, ...]:
    """The names of all checks: rows of the catalogue without motion."""
    return tuple(_CHECKS)


def check_class(name: str) -> type[Check]:
    """The class of a check by its name. Raises ValueError for an unknown name, with the nearest valid ones."""
    if name not in _CHECKS:
        raise ValueError(f"no check is named {name!r}; {nearest(name, check_names())}")
    module, _, attribute = _CHECKS[name].partition(":")
    found: type[Check] = getattr(importlib.import_module(f"gnomon.cases.{module}"), attribute)
    return found


def get_check(name: str, variant: str | None = None, **parameters: Number) -> Check:
    """A check with exact numbers (SI units). A variant's numbers are overridden by those given.

    Raises ValueError for an unknown name, variant or parameter and for numbers outside the domain.
    """
    return check_class(name)(variant, **parameters)
