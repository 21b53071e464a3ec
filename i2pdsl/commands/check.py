"""`i2p check`: mistakes only."""

from __future__ import annotations

from pathlib import Path

import click

from i2pdsl.errors import Diagnostic, StoryError
from i2pdsl.folders import written_files
from i2pdsl.output import DONE, WRONG, output_json, show


@click.command()
@click.argument("paths", nargs=-1, required=True, type=click.Path())
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def check(paths: tuple[str, ...], as_json: bool) -> int:
    """Check stories, libraries, worlds and studies, or whole folders of them."""
    from i2pdsl.language.check import TypedStory, check_source
    from i2pdsl.language.statements import read_source
    from i2pdsl.worlds.drawings import beside
    from i2pdsl.worlds.find import find_vocabulary, world_warnings
    from i2pdsl.worlds.kinds import kind_of, parse_world

    diagnostics: list[Diagnostic] = []
    files: list[str] = []
    for path in paths:
        try:
            files += [str(f) for f in written_files(path)]
        except StoryError as problem:
            diagnostics.extend(problem.diagnostics)
    files = list(dict.fromkeys(files))
    for name in files:
        try:
            source = read_source(name)
            if name.endswith(".world"):
                spec = parse_world(source, Path(name).stem, beside(Path(name).parent))
                diagnostics.extend(kind_of(spec).warnings(spec, name))
            elif name.endswith(".study"):
                from i2pdsl.study.check import check_study
                from i2pdsl.study.parse import parse_study

                check_study(parse_study(source, Path(name)))
            else:
                folder = Path(name).parent
                checked = check_source(source, find_vocabulary, folder)
                diagnostics.extend(checked.warnings)
                if isinstance(checked, TypedStory):
                    diagnostics.extend(world_warnings(checked.world, folder, checked))
        except StoryError as problem:
            diagnostics.extend(problem.diagnostics)
    diagnostics = list(dict.fromkeys(diagnostics))
    wrong = any(d.severity == "error" for d in diagnostics)
    if as_json:
        shown = [d.as_json() for d in diagnostics]
        output_json({"ok": not wrong, "files": files, "diagnostics": shown})
    else:
        show(diagnostics)
        if not wrong:
            click.echo(f"{len(files)} file{'s' * (len(files) != 1)} checked: no mistakes", err=True)
    return WRONG if wrong else DONE
