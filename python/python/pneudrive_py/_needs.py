"""Packages that some functions need, and most users do without."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def needs(package: str) -> Iterator[None]:
    """Says what to install where ``package``, which is imported inside, is not there."""
    try:
        yield
    except ModuleNotFoundError as missing:
        raise ModuleNotFoundError(f"this needs {package}: pip install {package}", name=missing.name) from missing
