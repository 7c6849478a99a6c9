"""Cases by name. Modules are imported on first use, so that listing names is instant."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from importlib.metadata import entry_points

from gnomon.cases.case import Case
from gnomon.cases.check import Check
from gnomon.cases.numbers import nearest
from gnomon.reference.precision import Number

_MODULES = {
    "pendulum_simple": "pendulum:PendulumSimple",
    "harmonic_oscillator": "harmonic:HarmonicOscillator",
    "duffing_unforced": "duffing:DuffingUnforced",
    "damped_oscillator": "damped:DampedOscillator",
    "cycloidal_pendulum": "cycloid:CycloidalPendulum",
    "kepler_orbit": "kepler:KeplerOrbit",
    "euler_top": "euler_top:EulerTopCase",
    "foucault_pendulum_linear": "foucault:FoucaultLinear",
    "foucault_precession": "foucault:FoucaultPrecession",
    "projectile_parabola": "projectile:ProjectileParabola",
    "projectile_stokes_drag": "stokes:ProjectileStokesDrag",
    "projectile_quadratic_drag": "quadratic_drag:ProjectileQuadraticDrag",
    "pendulum_quadratic_damping": "damped_pendulum:PendulumQuadraticDamping",
    "vertical_quadratic_drag": "quadratic_drag:VerticalQuadraticDrag",
    "ink_jet_printer": "droplets:InkJetPrinter",
    "millikan_oil_drop": "droplets:MillikanOilDrop",
    "charge_in_E_and_B": "charge:ChargeInFields",
    "relativistic_charge": "charge:RelativisticChargeCase",
    "forced_oscillator": "forced:ForcedOscillator",
    "second_order_linear_ode": "forced:SecondOrderLinearOde",
    "time_varying_force": "forced:TimeVaryingForce",
    "inertial_straight_line": "rotating_fall:InertialStraightLine",
    "planet_tunnel": "planet_tunnel:PlanetTunnelCase",
    "planet_tunnel_rotating": "turning_planet:PlanetTunnelRotating",
    "radial_fall_inverse_square": "radial:RadialFallInverseSquare",
    "free_fall_first_order": "rotating_fall:FreeFallFirstOrder",
    "free_fall_rotating_earth": "rotating_fall:FreeFallRotatingEarth",
    "free_fall_rotating_frame_centrifugal": "rotating_fall:FreeFallCentrifugal",
    "tower_drop": "tower:TowerFall",
    "foucault_pendulum_nonlinear": "foucault_nonlinear:FoucaultNonlinear",
    "bouncing_ball": "bouncing_ball:BouncingBall",
    "block_incline_friction": "block_incline:BlockInclineFriction",
    "coulomb_friction_oscillator": "coulomb:CoulombFrictionOscillator",
    "stick_slip_belt": "stick_slip:StickSlipBelt",
    "torpedo_firing_pin": "firing_pin:TorpedoFiringPin",
    "sliding_can": "sliding_can:SlidingCanCase",
    "rotating_pendulum": "hoop:RotatingPendulum",
    "rotating_pendulum_free_hoop": "hoop_free:RotatingPendulumFreeHoop",
    "rotating_pendulum_swept": "hoop_free:RotatingPendulumSwept",
    "bearing_reaction_torque_stability": "hoop:BearingReactionTorqueStability",
    "gyrocompass": "hoop:Gyrocompass",
    "small_vibrations_3dof_chain": "small_vibrations:SmallVibrationsChain",
    "small_vibrations_mdof": "small_vibrations:SmallVibrations",
    "bead_rotating_wire_vertical_plane": "bead_wire:BeadOnRotatingWire",
    "projectile_parabolic_coordinates": "parabolic:ProjectileInParabolicCoordinates",
    "rayleigh_dissipation_mdof": "rayleigh:RayleighDissipation",
    "two_body": "two_body:TwoBody",
    "equilateral_three_body": "three_body:EquilateralThreeBody",
    "chain_off_table": "chain_edge:ChainOffTable",
    "chain_quarter_circle": "chain_quarter:ChainQuarterCircle",
    "chain_over_pulley": "chain_edge:ChainOverPulley",
    "chain_in_circular_tube": "equivalent_pendulum:ChainInCircularTube",
    "moment_of_momentum_pendulum": "equivalent_pendulum:MomentOfMomentumPendulum",
    "impulse_instantaneous": "pulse:ImpulseInstantaneous",
    "ballistic_pendulum": "ballistic:BallisticPendulumCase",
    "torque_impulse_on_arm": "arm:TorqueImpulseOnArm",
    "restitution_impact_1d_2d": "two_blocks:RestitutionImpact",
    "three_ball_chain": "ball_line:ThreeBallChain",
    "newtons_cradle": "ball_line:NewtonsCradle",
    "oblique_impact": "oblique:ObliqueImpact",
    "work_energy_spring_block": "spring_block:WorkEnergySpringBlock",
    "bead_leaving_sphere": "contact_loss:BeadLeavingSphere",
    "amusement_park": "contact_loss:AmusementPark",
    "pendulum_on_string": "contact_loss:PendulumOnString",
    "rubber_tube_thin": "rubber_tube:RubberTubeThin",
    "rubber_tube_thick": "rubber_tube:RubberTubeThick",
    "slider_rotating_slot": "slot:SliderRotatingSlot",
    "chain_smooth_curve": "chain_curve:ChainSmoothCurve",
    "curve_sliding_small": "curve:CurveSlidingSmall",
    "curve_sliding_quartic": "curve:CurveSlidingQuartic",
    "curve_sliding_catenary": "curve:CurveSlidingCatenary",
    "central_force_conservation": "central:CentralForceConservation",
    "central_force_hanging_mass": "central:CentralForceHangingMass",
    "central_force_logarithmic": "central:CentralForceLogarithmic",
    "central_force_fifth_power": "fifth_power:CentralForceFifthPower",
    "central_force_shortened_string": "shortened_string:CentralForceShortenedString",
    "dumbbell_spring": "central:DumbbellSpring",
    "pendulum_on_cart": "cart_pendulum:PendulumOnCart",
    "two_mass_spring": "pair:TwoMassSpring",
    "center_of_mass_motion": "pair:CenterOfMassMotion",
    "exploding_projectile": "fragments:ExplodingProjectile",
    "man_on_cart": "man_on_cart:ManOnCart",
    "dumbbell_free_flight": "pair:DumbbellFreeFlight",
    "atwood_pulley_systems": "uniform:AtwoodPulleySystems",
    "wedge_block_energy_momentum": "uniform:WedgeBlock",
    "lagrange_top": "lagrange_top:LagrangeTopCase",
    "lagrange_top_fast": "top_models:LagrangeTopFast",
    "lagrange_top_small_nutation": "top_models:LagrangeTopSmallNutation",
    "lagrange_top_attitude": "lagrange_top:LagrangeTopAttitude",
    "lagrange_top_sleeping_separatrix": "lagrange_top:LagrangeTopSleepingSeparatrix",
    "double_pendulum": "double_pendulum:DoublePendulum",
    "spherical_pendulum": "spherical_pendulum:SphericalPendulumCase",
    "symmetric_top_torque_free": "symmetric_top:SymmetricTopTorqueFree",
    "rigid_body_stokes_medium_falling": "stokes_body_loaded:RigidBodyStokesMediumFalling",
    "rigid_body_stokes_medium_torque": "stokes_body_loaded:RigidBodyStokesMediumTorque",
    "rigid_body_stokes_medium": "stokes_body:RigidBodyStokesMedium",
    "holonomic_constraint_dae": "cartesian_pendulum:HolonomicConstraintDae",
    "billiard_ball_attitude": "billiard_spin:BilliardBallAttitude",
    "billiard_ball_drill": "billiard_spin:BilliardBallDrill",
    "billiard_ball": "billiard:BilliardBallCase",
    "spring_pendulum": "spring_pendulum:SpringPendulum",
    "swinging_atwood": "swinging_atwood:SwingingAtwood",
    "ignorable_coordinates": "ignorable:ParticleOnCone",
    "particle_on_paraboloid": "ignorable:ParticleOnParaboloid",
    "particle_on_torus": "ignorable:ParticleOnTorus",
    "sliding_ladder": "sliding_rod:SlidingLadderCase",
    "rigid_link_plane_motion": "sliding_rod:RigidLinkPlaneMotion",
    "foucault_pendulum_centrifugal": "foucault_centrifugal:FoucaultInPlaneCentrifugal",
    "bouncing_ball_incline": "bouncing_incline:BouncingBallIncline",
    "bouncing_ball_table": "vibrating_table:BouncingBallTable",
    "hanging_springs": "springs:HangingSpringsCase",
    "chaplygin_sleigh": "nonholonomic:ChaplyginSleighCase",
    "knife_edge_incline": "nonholonomic:KnifeEdgeIncline",
    "rolling_disc": "rolling_disc:RollingDisc",
    "rotation_fixed_axis_compound_pendulum": "compound_pendulum:CompoundPendulum",
    "rolling_sphere_in_bowl": "compound_pendulum:RollingSphereInBowl",
    "dynamics_of_free_rigid_body_in_gravity": "free_body:DynamicsOfFreeRigidBodyInGravity",
    "belt_driven_machine": "machines:BeltDrivenMachine",
    "flywheel": "machines:FlywheelCase",
    "flywheel_coast_down": "machines:FlywheelCoastDown",
    "engineering_design_analysis": "governor:EngineeringDesignAnalysis",
    "gyrocompass_damped_nonlinear": "gyrocompass_free:GyrocompassDampedNonlinear",
    "gyrocompass_tilting": "gyrocompass_free:GyrocompassTilting",
    "gyrocompass_damped": "gyrocompass_damped:GyrocompassDamped",
    "rolling_bodies": "rolling:RollingBodies",
    "yo_yo": "rolling:YoYo",
}


_CHECKS = {
    "inertia_tensor_special_bodies": "checks_inertia:InertiaTensorSpecialBodies",
    "inertia_composite_parallel_axis": "checks_inertia:InertiaCompositeParallelAxis",
    "inertia_transformation_principal": "checks_inertia:InertiaTransformationPrincipal",
    "com_rigid_body": "checks_centres:ComRigidBody",
    "moment_equipollent": "checks_centres:MomentEquipollent",
    "gravity_field_particle_body": "checks_gravity:GravityFieldParticleBody",
    "weight_local_gravity": "checks_gravity:WeightLocalGravity",
    "falling_target": "checks_aim:FallingTarget",
    "apparent_gravity_earth": "checks_frames:ApparentGravityEarth",
    "frame_transformation": "checks_frames:FrameTransformation",
    "material_frame_indifference": "checks_frames:MaterialFrameIndifference",
    "work_constant_linear_coulomb": "checks_work:WorkConstantLinearCoulomb",
    "conservative_force_test": "checks_work:ConservativeForceTest",
    "hamilton_action": "checks_action:HamiltonAction",
    "amusement_rides": "checks_rides:AmusementRides",
    "capstan_belt": "checks_belt:CapstanBelt",
    "rotor_dynamic_balance": "checks_bodies:RotorDynamicBalance",
    "work_energy_rigid_body": "checks_energy:WorkEnergyRigidBody",
    "generalized_impulse": "checks_bodies:GeneralizedImpulse",
    "projectile_coriolis_first_order": "checks_perturbation:ProjectileCoriolisFirstOrder",
    "falkland_gunnery": "checks_perturbation:FalklandGunnery",
    "stability_pendulum_linearisation": "checks_perturbation:StabilityPendulumLinearisation",
    "rod_tension_circular": "checks_particles:RodTensionCircular",
    "moment_momentum_moving_point": "checks_particles:MomentMomentumMovingPoint",
    "internal_potential_energy": "checks_particles:InternalPotentialEnergy",
}
"""Rows without motion."""


def names() -> tuple[str, ...]:
    """The names of all moving cases, entry points of the group `gnomon.cases` included."""
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
        return _checked(getattr(importlib.import_module(module), attribute), path)
    except (
        Exception,
        SystemExit,
        KeyboardInterrupt,
    ) as error:  # whatever a user's own module does while it is imported
        raise ValueError(
            f"{path}: {type(error).__name__}: {error}; give package.module:Class of a subclass of gnomon.cases.Case"
        ) from None


def _checked(found: object, path: str) -> type[Case]:
    if not (isinstance(found, type) and issubclass(found, Case)):
        raise ValueError(f"{path} is no subclass of gnomon.cases.Case")
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


def checks() -> tuple[str, ...]:
    """The names of all checks: rows of the catalogue without motion."""
    return tuple(_CHECKS)


def check_class(name: str) -> type[Check]:
    """The class of a check by its name. Raises ValueError for an unknown name, with the nearest valid ones."""
    if name not in _CHECKS:
        raise ValueError(f"no check is named {name!r}; {nearest(name, checks())}")
    module, _, attribute = _CHECKS[name].partition(":")
    found: type[Check] = getattr(importlib.import_module(f"gnomon.cases.{module}"), attribute)
    return found


def get_check(name: str, variant: str | None = None, **parameters: Number) -> Check:
    """A check with exact numbers (SI units). A variant's numbers are overridden by those given.

    Raises ValueError for an unknown name, variant or parameter and for numbers outside the domain.
    """
    return check_class(name)(variant, **parameters)
