"""Errors that are not the caller's mistake (that is ValueError): files, models and devices that cannot be used."""

from lfdcore._core import DataError, DeviceError, ModelError

__all__ = ["DataError", "DeviceError", "ModelError"]
