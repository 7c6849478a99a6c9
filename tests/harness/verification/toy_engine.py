"""A toy engine: point masses under gravity and force laws, advanced by symplectic Euler. Order 1."""

from gnomon.verify import IDENTITY, Readings, from_engine


class ToyEngine:
    def load(self, scene):
        self.t, self.scene = 0.0, scene
        self.mass = {body.name: body.mass for body in scene.bodies}
        self.position = {body.name: body.position for body in scene.bodies}
        self.velocity = {body.name: body.velocity for body in scene.bodies}

    def step(self, dt):
        forces = self.forces()
        for name, mass in self.mass.items():
            acceleration = add(self.scene.gravity, forces[name], 1 / mass)
            self.velocity[name] = add(self.velocity[name], acceleration, dt)
            self.position[name] = add(self.position[name], self.velocity[name], dt)
        self.t += dt

    def forces(self):
        total = {name: (0.0, 0.0, 0.0) for name in self.mass}
        for force in self.scene.forces:
            position, velocity = self.position[force.body], self.velocity[force.body]
            if force.partner:
                position = add(position, self.position[force.partner], -1)
                velocity = add(velocity, self.velocity[force.partner], -1)
            value = force.law(self.t, position, velocity)
            total[force.body] = add(total[force.body], value)
            if force.partner:
                total[force.partner] = add(total[force.partner], value, -1)
        return total

    def read(self):
        rest = (0.0, 0.0, 0.0)
        bodies = {name: (self.position[name], IDENTITY, self.velocity[name], rest) for name in self.mass}
        return Readings(bodies=bodies)


def add(a, b, factor=1.0):
    return tuple(x + factor * y for x, y in zip(a, b, strict=True))


INTEGRATOR = from_engine(
    ToyEngine,
    name="toy",
    order=1,
    tokens=("position_force", "velocity_force", "time_force", "mutual_force"),
)
