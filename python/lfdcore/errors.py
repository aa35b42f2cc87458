"""Errors that are not the caller's mistake (that is ValueError): files and models that cannot be used."""

from lfdcore._core import DataError, ModelError

__all__ = ["DataError", "ModelError"]
