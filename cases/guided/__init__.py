"""Cases: points, chains and rings guided by wires, curves, surfaces and hoops."""
