"""Exact motions of points, chains and rings guided by wires, curves, surfaces and hoops."""
