"""What participants practise with: a film, or a pair, that is none of the study's."""

from __future__ import annotations

from i2pdsl.scripts import Script
from i2pdsl.study.check import Ground
from i2pdsl.study.films import Films
from i2pdsl.study.spec import Film
from i2pdsl.worlds.kind import Watch


def practice_scripts(films: Films, watch: Watch) -> list[Script]:
    """One script, or two for a pair: of a seed that the study has not, without an audience, so that
    nothing has to be searched. Where scripts are given, one that is not shown, if there is any.

    Raises StoryError.
    """
    study = films.study
    pair = study.pairs[0] if study.pairs else None
    names = [pair.first, pair.second] if pair else [study.conditions[0].name]
    method = min(study.methods, key=lambda method: not method.naive)
    seed = max(study.seeds) + 1
    found = []
    for number, name in enumerate(names):
        ground = films.grounds[name, method.name]
        found.append(_practice(ground, Film(name, method.name, seed + number), watch))
    return found


def _practice(ground: Ground, film: Film, watch: Watch) -> Script:
    if ground.story is not None:
        return ground.story.solve(film.seed, naive=True, watch=watch).script
    paths = ground.scripts
    return Script.load(paths[min(film.seed, len(paths) - 1)], watch)
