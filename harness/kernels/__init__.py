"""A case's equations as compiled code, and machine code that is kept."""
