"""Machine code of many small functions that call one another, made in a fraction of the time.

numba makes machine code of each function with all functions below it: what stands at the bottom of
a chain of ten calls is optimized and translated ten times. Here the functions below wait, and only
the one that Python calls is made, once, of all that it needs. Each is simplified alone before: that
costs next to nothing, and makes loops of small functions up to a seventh faster. What only that one
function calls is private to it, so that what all of its calls have in common is known inside: a
third faster again, and a third less code.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from typing import Any, Protocol

COMPILING = "compiling, once, up to a minute: kept for later runs"
COMPILING_IN_VAIN = "compiling, up to a minute: nothing can be kept in the user's cache folder"
"""What watchers are told."""

#: What is used of numba below its public interface; where any is missing, numba does as usual.
_OF_LIBRARIES = (
    *("_ensure_finalized", "_finalize_final_module", "_get_module_for_linking"),
    *("_optimize_final_module", "add_linking_library", "finalize", "get_pointer_to_function"),
)


@cache
def _codegen_class() -> Any:
    """The class of numba's code generator whose libraries wait; None where numba is another."""
    try:
        llvm = import_module("llvmlite.binding")
        from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
        from numba.core.compiler_lock import require_global_compiler_lock
        from numba.core.environment import lookup_environment
    except ImportError:
        return None
    there = [hasattr(JITCodeLibrary, name) for name in _OF_LIBRARIES]
    if not all((*there, hasattr(JITCPUCodegen, "set_env"))):
        return None

    class Library(JITCodeLibrary):  # type: ignore[misc]
        """The code of a function, which becomes machine code when Python wants to call it."""

        def add_linking_library(self, library: Any) -> None:
            """Note a library that is called; it may go on waiting."""
            self._linking_libraries.append(library)

        def get_pointer_to_function(self, name: str) -> int:
            """Address of a function; 0 for the one that Python would call where it never will."""
            if not self._finalized and not self._defines(name):
                return 0
            return int(super().get_pointer_to_function(name))

        def _defines(self, name: str) -> bool:
            return any(function.name == name for function in self._final_module.functions)

        def _below(self, seen: dict[Any, None]) -> None:
            """Add all libraries below to those seen."""
            for library in self._linking_libraries:
                if library not in seen:
                    seen[library] = None
                    if isinstance(library, Library) and not library._finalized:
                        library._below(seen)

        def _part(self) -> Any:
            """The function by itself, to be linked into others."""
            module = self._final_module.clone()
            for function in module.functions:
                if not function.is_declaration and function.linkage == llvm.Linkage.external:
                    function.linkage = "linkonce_odr"
            return module

        def _link(self) -> None:
            """Link all that is called, each part after one that calls it."""
            seen: dict[Any, None] = {}
            self._below(seen)
            parts: list[Any] = []
            home: dict[str, int] = {}
            for library in seen:
                waits = isinstance(library, Library) and not library._finalized
                part = library._part() if waits else library._get_module_for_linking().clone()
                for function in part.functions:
                    if not function.is_declaration and (waits or function.name not in home):
                        home[function.name] = len(parts)
                parts.append(part)
            called = _declared(self._final_module)
            linked: set[int] = set()
            while called:
                number = home.get(called.pop(), -1)
                if number >= 0 and number not in linked:
                    linked.add(number)
                    called += _declared(parts[number])
                    self._final_module.link_in(parts[number])

        def finalize(self) -> None:
            """Make machine code of the function and of all below it."""
            require_global_compiler_lock()
            self._codegen._check_llvm_bugs()
            self._raise_if_finalized()
            own = {function.name for function in _defined(self._final_module)}
            self._link()
            for function in _defined(self._final_module):
                if function.name not in own:
                    function.linkage = llvm.Linkage.internal
            self._optimize_final_module()
            self._final_module.verify()
            self._finalize_final_module()
            for variable in self._final_module.global_variables:
                environment = lookup_environment(variable.name)
                if environment is not None and self._codegen._engine.is_symbol_defined(
                    variable.name
                ):
                    self._codegen.set_env(variable.name, environment)

    class Codegen(JITCPUCodegen):  # type: ignore[misc]
        """Makes libraries that wait."""

        _library_class = Library

        def set_env(self, env_name: str, env: Any) -> None:
            """Give a function the objects that it refers to, once there is machine code of it."""
            if self._engine.is_symbol_defined(env_name):
                super().set_env(env_name, env)

    return Codegen


def _defined(module: Any) -> list[Any]:
    """The functions that a module holds."""
    return [function for function in module.functions if not function.is_declaration]


def _declared(module: Any) -> list[str]:
    """Names of the functions that a module calls and does not hold."""
    return [function.name for function in module.functions if function.is_declaration]


@contextmanager
def _brief_errors() -> Iterator[None]:
    """Let an assignment to a slice of another size be refused without the two sizes.

    To write them down numba compiles what makes text of numbers: one function in nine, a tenth of
    the time, for an error that does not occur.
    """
    from numba.core.registry import cpu_target

    home = import_module("numba.np.arrayobj")
    refused = getattr(home, "raise_with_shape_context", None)
    context = cpu_target.typing_context
    context.refresh()
    kind = None if refused is None else context.resolve_value_type(refused)
    found = {
        getattr(template, "metadata", {}).get("target"): template
        for template in getattr(kind, "templates", ())
    }
    if not {"generic", "CPU"} <= found.keys():  # numba is another
        yield
        return
    usual = found["CPU"].__dict__["_overload_func"]
    found["CPU"]._overload_func = found["generic"].__dict__["_overload_func"]
    try:
        yield
    finally:
        found["CPU"]._overload_func = usual


@contextmanager
def _late_linking() -> Iterator[None]:
    """Compile, in this block, functions that Python does not call only with those that it calls."""
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.registry import cpu_target

    with global_compiler_lock:
        codegen, late = cpu_target.target_context.codegen(), _codegen_class()
        usual, collects = type(codegen), gc.isenabled()
        if late is not None and usual is late.__base__:
            codegen.__class__ = late
        gc.disable()  # there is little garbage, and looking for it takes a sixth of the time
        try:
            yield
        finally:
            codegen.__class__ = usual
            if collects:
                gc.enable()


def linked_late(machine: Any, *, kept: bool) -> Any:
    """A function compiled by numba for Python, whose parts become machine code only with it.

    Those that `watching` names are told, also where it is only read back; `kept`: the machine code
    will be there for later runs.
    """
    usual = machine.compile

    def compile_late(signature: Any) -> Any:
        with _late_linking(), _brief_errors(), _watched(kept):
            return usual(signature)

    machine.compile = compile_late
    return machine


def part_of_others(function: Callable[..., Any]) -> Any:
    """A function compiled by numba for other compiled functions; Python cannot call it.

    It is compiled for types of arguments, never anew for values that callers have written out.
    """
    from numba import njit, types

    part = njit(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)(function)
    usual = part.get_call_template

    def template_of(arguments: Any, by_name: Any) -> Any:
        named = {name: types.unliteral(kind) for name, kind in by_name.items()}
        return usual(tuple(types.unliteral(kind) for kind in arguments), named)

    part.get_call_template = template_of
    return part


class Watcher(Protocol):
    """What wants to know when functions are compiled or read back, which takes its time."""

    def pause(self) -> None:
        """It begins."""

    def say(self, why: str) -> None:
        """The function is not kept, and has to be compiled."""

    def go_on(self) -> None:
        """It is over."""


_WATCHERS: list[Watcher] = []


@contextmanager
def watching(watcher: Watcher) -> Iterator[None]:
    """Tell of what is compiled or read back within this block."""
    _WATCHERS.append(watcher)
    try:
        yield
    finally:
        _WATCHERS.remove(watcher)


@contextmanager
def _watched(kept: bool) -> Iterator[None]:
    """Tell the watchers, and once numba begins to compile why: not where it finds what was kept."""
    from numba.core import event

    said = False

    class Listener(event.Listener):  # type: ignore[misc]
        def on_start(self, event: Any) -> None:
            nonlocal said
            if not said:
                said = True
                for watcher in _WATCHERS:
                    watcher.say(COMPILING if kept else COMPILING_IN_VAIN)

        def on_end(self, event: Any) -> None:
            """Nothing: watchers go on at the end of the block."""

    for watcher in _WATCHERS:
        watcher.pause()
    try:
        with event.install_listener("numba:compile", Listener()):
            yield
    finally:
        for watcher in _WATCHERS:
            watcher.go_on()
