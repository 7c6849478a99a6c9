"""The contract of integrators: what one implements and is given, and the validation of what it returns."""
