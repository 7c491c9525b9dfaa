"""What a run carries on from step to step, so that another one goes on from there."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar


class Resumable:
    """Base of the parts of a run whose attributes a checkpoint has, by their names.

    Attributes that are saved and resumed in their own way, or lists of such, keep to that.
    """

    CARRIED: ClassVar[tuple[str, ...]]
    """Names of the attributes that are carried on."""

    def saved(self) -> dict[str, Any]:
        """The attributes that are carried on, for `resume`."""
        return {name: _saved(getattr(self, name)) for name in self.CARRIED}

    def resume(self, saved: Mapping[str, Any]) -> None:
        """Go on from where another one of the same scene was saved."""
        for name in self.CARRIED:
            setattr(self, name, _resumed(getattr(self, name), saved[name]))


def _saved(own: Any) -> Any:
    """What a checkpoint has of an attribute."""
    if isinstance(own, list):
        return [_saved(each) for each in own]
    return own.saved() if hasattr(own, "saved") else own


def _resumed(own: Any, saved: Any) -> Any:
    """The attribute by what a checkpoint has of it."""
    if isinstance(own, list) and len(own) == len(saved):
        return [_resumed(*both) for both in zip(own, saved, strict=True)]
    if not hasattr(own, "resume"):
        return saved
    own.resume(saved)
    return own
