"""The contract of integrators: their interface, the problem that they are given, the validation of their solutions."""
