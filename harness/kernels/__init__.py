"""Trace the equations of a case, generate source text from them, compile it and keep the machine code on disk."""
