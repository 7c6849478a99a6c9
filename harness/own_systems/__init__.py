"""A user's own equations as a case: forms that tracing derives, a reference in high precision, the limit of rounding."""
