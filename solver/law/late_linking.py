"""Late linking of compiled functions: machine code only of those that Python calls.

numba makes machine code of each function with all functions below it: what stands at the bottom of
a chain of ten calls is optimized and translated ten times. Here the functions below wait, as code
of LLVM that is simplified, and the one that Python calls is made once, of all that it needs: a
third to a fifth of the time of compilation. What it needs is private to it, so that what all of
its calls have in common is known inside.

This uses `numba.core.codegen` below its public interface: in the code generator of numba the class
of libraries is another while such a function is compiled. Where numba has no such class, functions
are compiled as numba does by itself.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from typing import Any

#: What is used of numba's libraries below its public interface.
_USED = (
    *("_get_module_for_linking", "_optimize_final_module", "add_linking_library", "finalize"),
    "get_pointer_to_function",
)


@cache
def _library_class() -> Any:
    """The class of libraries that wait to be linked; None where numba's are others."""
    try:
        llvm = import_module("llvmlite.binding")
        from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
        from numba.core.environment import lookup_environment
    except ImportError:
        return None
    if not all(hasattr(JITCodeLibrary, name) for name in _USED):
        return None
    if getattr(JITCPUCodegen, "_library_class", None) is not JITCodeLibrary:
        return None

    class Library(JITCodeLibrary):  # type: ignore[misc]
        """The code of a function, which becomes machine code when Python is to call it."""

        def add_linking_library(self, library: Any) -> None:
            """Note a library that is called; it may go on waiting."""
            self._linking_libraries.append(library)

        def get_pointer_to_function(self, name: str) -> int:
            """Address of a function; 0 for one that Python would call where it never will."""
            if not self._finalized and not self._defines(name):
                return 0
            return int(super().get_pointer_to_function(name))

        def _defines(self, name: str) -> bool:
            return any(function.name == name for function in self._final_module.functions)

        def _get_module_for_linking(self) -> Any:
            """The function by itself, for others to be linked with, without machine code."""
            if self._finalized:
                return super()._get_module_for_linking()
            module = self._final_module.clone()
            for function in _defined(module):
                if function.linkage == llvm.Linkage.external:
                    function.linkage = llvm.Linkage.linkonce_odr
            return module

        def finalize(self) -> None:
            """Make machine code of the function and of all below it."""
            self._own = {function.name for function in _defined(self._final_module)}
            # Callers first: what nothing has called so far is not linked.
            self._linking_libraries = _below(self)
            super().finalize()
            for variable in self._final_module.global_variables:
                environment = lookup_environment(variable.name)
                if environment is not None:
                    self._codegen.set_env(variable.name, environment)

        def _optimize_final_module(self) -> None:
            """Make all but the function itself private, and optimize."""
            for function in _defined(self._final_module):
                if function.name not in self._own:
                    function.linkage = llvm.Linkage.internal
            super()._optimize_final_module()

    def _below(top: Any) -> list[Any]:
        """All libraries below one that wait or are called by one that waits, callers first."""
        order: dict[Any, None] = {}

        def visit(library: Any) -> None:
            if isinstance(library, Library) and not library._finalized:
                for called in library._linking_libraries:
                    if called not in order:
                        visit(called)
            order[library] = None

        visit(top)
        del order[top]
        return list(order)[::-1]

    return Library


def _defined(module: Any) -> list[Any]:
    """The functions that a module holds."""
    return [function for function in module.functions if not function.is_declaration]


@contextmanager
def late_linking() -> Iterator[None]:
    """Make machine code, in this block, of functions that Python calls only."""
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.registry import cpu_target

    with global_compiler_lock:
        codegen, late = cpu_target.target_context.codegen(), _library_class()
        if late is None or "_library_class" in vars(codegen):
            yield
            return
        usual = codegen.set_env

        def set_env(name: str, environment: Any) -> None:
            """Give a function the objects that it refers to, once there is machine code of it."""
            if codegen._engine.is_symbol_defined(name):
                usual(name, environment)

        codegen._library_class, codegen.set_env = late, set_env
        collects = gc.isenabled()
        gc.disable()  # there is little garbage, and looking for it takes a sixth of the time
        try:
            yield
        finally:
            del codegen._library_class, codegen.set_env
            if collects:
                gc.enable()
