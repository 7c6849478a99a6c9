"""Count the calls of compiled equations without compiling the equations a second time."""

from functools import cache
from typing import Any

CODE = """
define void @counting(double %t, ptr %y, ptr %p, ptr %out) {{
  %place = getelementptr double, ptr %p, i64 {place}
  %before = load double, ptr %place
  %after = fadd double %before, 1.0
  store double %after, ptr %place
  %function = inttoptr i64 {address} to ptr
  tail call void %function(double %t, ptr %y, ptr %p, ptr %out)
  ret void
}}
"""
"""The counting function in LLVM's language; numba would take half a second to generate it."""


def address(function: int, place: int) -> int:
    """Address of a C function (t, y, p, out) that adds 1 to p[place], then calls the C function at an address."""
    found: int = _compiled(function, place).get_function_address("counting")
    return found


@cache
def _compiled(function: int, place: int) -> Any:
    from llvmlite import binding  # loads LLVM
    from numba.core.registry import cpu_target

    cpu_target.target_context.codegen()  # numba initializes LLVM for this processor
    module = binding.parse_assembly(CODE.format(address=function, place=place))
    engine = binding.create_mcjit_compiler(module, binding.Target.from_default_triple().create_target_machine())
    engine.finalize_object()
    return engine
