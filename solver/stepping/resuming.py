"""Compliances of responses, as a checkpoint keeps them: which columns were computed together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from solver.stepping.elastic_response import ElasticResponse


def saved_compliances(responses: Sequence[Any]) -> list[Any]:
    """What the responses of meshed bodies have computed; None for all others."""
    return [
        response.compliance.saved() if isinstance(response, ElasticResponse) else None
        for response in responses
    ]


def repeat_compliances(responses: Sequence[Any], saved: Sequence[Any]) -> None:
    """Compute the same again, to the last digit; collective."""
    for response, compliance in zip(responses, saved, strict=True):
        if compliance is not None:
            response.compliance.repeat(compliance)
