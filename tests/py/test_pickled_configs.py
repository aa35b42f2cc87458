"""Every struct of settings survives a pickle by the names of its fields, and is refused under wrong ones."""

import copy
import pickle
from collections.abc import Callable
from typing import Any

import pytest

from lfdcore import _core
from lfdcore.control import CommandTiming
from lfdcore.geometry import Footprint, MotionLimits, Pose2

CONFIGS = [
    kind
    for module in vars(_core).values()
    if isinstance(module, type(_core))
    for name, kind in vars(module).items()
    if name.endswith("Config")
]
every_config = pytest.mark.parametrize("kind", [*CONFIGS, CommandTiming, MotionLimits], ids=lambda kind: kind.__name__)


def fields(kind: type) -> list[str]:
    return [name for name, member in vars(kind).items() if isinstance(member, property)]


OTHERS: dict[type, Callable[[Any], list[Any]]] = {
    type(None): lambda _: [0.5],
    bool: lambda value: [not value],
    int: lambda value: [value + 1],
    float: lambda value: [0.9 * value or 0.01, 1.1 * value],
    str: lambda name: [{"forcing": "positions", "positions": "forcing"}[name]],
    Pose2: lambda _: [Pose2(0.1, 0.2, 0.3)],
    Footprint: lambda _: [Footprint(0.1, 0.2, 0.3)],
}
"""Other values of a field, by its type; a config's constructor may refuse some of them."""


def others(value: Any) -> list[Any]:
    return OTHERS[type(value)](value) if type(value) in OTHERS else [changed(type(value))]


def changed(kind: type) -> Any:
    """A config of which every field differs from its default."""
    settings: dict[str, Any] = {}
    for name in fields(kind):
        settings[name] = next(value for value in others(getattr(kind(), name)) if accepts(kind, settings, name, value))
    return kind(**settings)


def accepts(kind: type, settings: dict[str, Any], name: str, value: Any) -> bool:
    try:
        kind(**settings, **{name: value})
    except ValueError:
        return False
    return True


def plain(value: Any) -> Any:
    """A config as numbers, texts and dicts of them, which can be compared."""
    names = fields(type(value)) if type(value).__module__.startswith("lfdcore") else []
    return {name: plain(getattr(value, name)) for name in names} or value


def unpickled(kind: type, state: Any) -> Any:
    made = kind.__new__(kind)
    made.__setstate__(state)
    return made


def test_there_are_configs_to_be_tested() -> None:
    assert len(CONFIGS) >= 18


@every_config
def test_every_field_survives_a_pickle(kind: type) -> None:
    config, defaults = changed(kind), plain(kind())
    given = plain(config)
    assert fields(kind) and not [name for name in fields(kind) if given[name] == defaults[name]]
    assert plain(pickle.loads(pickle.dumps(config))) == plain(copy.deepcopy(config)) == given


@every_config
def test_fields_are_known_by_name_whatever_their_order(kind: type) -> None:
    config = changed(kind)
    state = config.__getstate__()
    assert list(state) == fields(kind)
    assert plain(unpickled(kind, dict(reversed(state.items())))) == plain(config)


@every_config
def test_an_unknown_or_missing_name_is_refused_and_named(kind: type) -> None:
    state = kind().__getstate__()
    with pytest.raises(ValueError, match=f"{kind.__name__} has no field 'colour'"):
        unpickled(kind, {**state, "colour": 1.0})
    for missing in state:
        with pytest.raises(ValueError, match=f"{kind.__name__}'s field '{missing}' is missing"):
            unpickled(kind, {name: value for name, value in state.items() if name != missing})


@every_config
def test_a_value_of_another_type_is_refused_and_named(kind: type) -> None:
    state = kind().__getstate__()
    for name, value in state.items():
        for wrong in wrong_for(value):
            with pytest.raises(ValueError, match=f"{kind.__name__}'s field '{name}' is {wrong!r}, of another type"):
                unpickled(kind, {**state, name: wrong})


def wrong_for(value: Any) -> list[Any]:
    """None is a value only where it is the default; a bool is neither a number nor absent."""
    if value is None:
        return ["many"]
    return [None, 1 if isinstance(value, str | bool) else "many"]


def test_a_constructor_takes_no_number_and_no_none_for_a_bool() -> None:
    flags = [(kind, name) for kind in CONFIGS for name in fields(kind) if isinstance(getattr(kind(), name), bool)]
    assert len(flags) > 3
    for kind, name in flags:
        for wrong in (None, 1, 0.0):
            with pytest.raises(TypeError, match=name):
                kind(**{name: wrong})


def test_values_that_the_constructor_refuses_are_refused_by_a_pickle_too() -> None:
    state = MotionLimits().__getstate__()
    with pytest.raises(ValueError, match="max_linear"):
        unpickled(MotionLimits, {**state, "max_linear": -1.0})
