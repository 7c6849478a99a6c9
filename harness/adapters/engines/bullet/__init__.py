"""PyBullet: its policies, the worlds, and the ways in which joints, ropes, forces and planes are built."""
