"""The plant of Drake for a scene: its world, its contact, and forces as expressions that it evaluates."""
