"""What is given beforehand of viewers and of the world as they believe it works, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from i2pdsl.errors import did_you_mean, error, whole_file
from i2pdsl.fit.model import POSSIBLE, RESPONSE, VIEWER
from i2pdsl.fit.questions import Study, Value
from i2pdsl.language.vocabulary import show_value


def settings_of(
    study: Study, fixed: Mapping[str, Value], grid: Mapping[str, Sequence[float]]
) -> tuple[dict[str, float], dict[str, Value], dict[str, Value]]:
    """Of what is given, the parameters of the model, the settings of the world as viewers believe
    it works, and those that change what can be believed, for `study`.

    Raises StoryError where a world has no such setting, or none with such a value.
    """
    parameters: dict[str, float] = {}
    settings: dict[str, Value] = {}
    reshaping: dict[str, Value] = {}
    known = study.words.settings
    given: list[tuple[str, Sequence[Value]]] = [*((n, [v]) for n, v in fixed.items())]
    for name, values in [*given, *grid.items()]:
        if (name in VIEWER or name in RESPONSE) and name not in grid:
            (value,) = values
            low, high = POSSIBLE[name]
            if isinstance(value, str) or not low <= value <= high:
                message = (
                    f"`{name}` cannot be {show_value(value)}: it is between {low:g} and {high:g}"
                )
                raise error("setting", message, whole_file("fit"))
            parameters[name] = value
            continue
        if name not in known or (name in grid and known[name].reshapes):
            message = f"there is no parameter, and no setting of the world, called `{name}`"
            hint = did_you_mean(name, {*known, *VIEWER, *RESPONSE})
            if name in known:
                message = (
                    f"`{name}` changes what can be believed, so its values have no common grid"
                )
                hint = f"compare them: `--against {name}={show_value(values[-1])}`"
            raise error("setting", message, whole_file("fit"), hint)
        for value in values:
            if not known[name].holds(value):
                message = f"`{name}` cannot be {show_value(value)}: it is {known[name].possible}"
                raise error("setting", message, whole_file("fit"))
        if name not in grid:
            (reshaping if known[name].reshapes else settings)[name] = values[0]
    return parameters, settings, reshaping
