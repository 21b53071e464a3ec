"""The command `i2p`: arguments in, results on standard output, messages on standard error.

Exit status (interfaces.md): 0 done, 1 the story, world or script is wrong, 2 wrong usage,
130 interrupted.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from i2pdsl.errors import Diagnostic, StoryError, error, whole_file

if TYPE_CHECKING:
    from i2pdsl.pipeline import Answer, Script, Story
    from i2pdsl.progress import Bars

DONE, WRONG, USAGE, INTERRUPTED = 0, 1, 2, 130


def main(arguments: list[str] | None = None) -> None:
    """The program."""
    sys.exit(run_command(arguments))


def run_command(arguments: list[str] | None = None) -> int:
    """Runs one command; returns the exit status."""
    try:
        result = program.main(args=arguments, prog_name="i2p", standalone_mode=False)
        return result if isinstance(result, int) else DONE
    except StoryError as problem:
        show(problem.diagnostics)
        return WRONG
    except click.Abort:
        click.echo("interrupted", err=True)
        return INTERRUPTED
    except click.ClickException as problem:
        problem.show()
        return USAGE
    except BrokenPipeError:
        # Whoever read our output has had enough; flushing what is left would fail again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE


def show(diagnostics: tuple[Diagnostic, ...] | list[Diagnostic]) -> None:
    """Diagnostics as people read them, on standard error."""
    for diagnostic in diagnostics:
        click.echo(diagnostic.render(), err=True)


def output_json(document: Any) -> None:
    """The one document of `--json`."""
    click.echo(json.dumps(document, ensure_ascii=False))


class Seeds(click.ParamType):
    """`0-19`, `3` or `1,4,7`."""

    name = "seeds"

    def convert(self, value: Any, param: Any, ctx: Any) -> list[int]:
        seeds: list[int] = []
        for part in str(value).split(","):
            first, dash, last = part.strip().partition("-")
            if not first.isdigit() or (dash and not last.isdigit()):
                self.fail(f"{value!r} are no seeds; write 0-19 or 1,4,7", param, ctx)
            span = range(int(first), int(last or first) + 1)
            if not span or len(span) > 10_000:
                self.fail(f"{part!r} is an empty or endless range", param, ctx)
            seeds.extend(span)
        return seeds


class Formats(click.ParamType):
    """`png,svg,gif,mp4,html`."""

    name = "formats"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[str, ...]:
        known = ("png", "svg", "gif", "mp4", "html")
        chosen = tuple(dict.fromkeys(p.strip() for p in str(value).split(",") if p.strip()))
        for name in chosen:
            if name not in known:
                self.fail(
                    f"there is no format {name!r}; formats are {', '.join(known)}", param, ctx
                )
        return chosen


class Assignment(click.ParamType):
    """`NAME=VALUE`."""

    name = "NAME=VALUE"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[str, str]:
        if isinstance(value, tuple):
            return value
        name, equals, text = str(value).partition("=")
        if not equals or not name.strip().isidentifier() or not text.strip():
            self.fail(f"{value!r} is not NAME=VALUE", param, ctx)
        return name.strip(), text.strip()


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="i2pdsl", prog_name="i2p")
def program() -> None:
    """Stories told to a simulated audience, by inverse inverse planning."""


# Making stories.


@program.command()
@click.argument("stories", nargs=-1, required=True, type=click.Path())
@click.option(
    "--seed", type=click.IntRange(0), default=None, help="Of the initial states; default 0."
)
@click.option("--seeds", type=Seeds(), default=None, help="Several seeds: 0-19 or 1,4,7.")
@click.option(
    "--out", type=click.Path(file_okay=False), default="out", help="Folder; default out/."
)
@click.option("--set", "settings", type=Assignment(), multiple=True, help="Replace a value.")
@click.option(
    "--format", "formats", type=Formats(), default="png,html", help="png,svg,gif,mp4,html"
)
@click.option(
    "--candidates", type=click.IntRange(1, 100), default=1, help="Visibly different ones."
)
@click.option("--naive", is_flag=True, help="No audience: the characters do what is best for them.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def run(
    stories: tuple[str, ...],
    seed: int | None,
    seeds: list[int] | None,
    out: str,
    settings: tuple[tuple[str, str], ...],
    formats: tuple[str, ...],
    candidates: int,
    naive: bool,
    as_json: bool,
) -> int:
    """Make stories: find the script, write it and its pictures."""
    from i2pdsl.progress import Bars

    if seed is not None and seeds is not None:
        raise click.UsageError("give --seed or --seeds, not both")
    chosen = seeds if seeds is not None else [seed or 0]
    loaded = [load_story(path, settings) for path in stories]
    several = len(loaded) > 1 or len(chosen) > 1 or seeds is not None
    results: list[dict[str, Any]] = []
    status = DONE
    for story in loaded:
        show(story.warnings)
        for number in chosen:
            folder = Path(out) / story.typed.name
            if len(chosen) > 1:
                folder = folder / f"seed-{number}"
            with Bars() as bars:
                result, finished = make(story, number, folder, formats, candidates, naive, bars)
            results.append(result)
            if not as_json:
                report(result)
            if not finished:
                status = INTERRUPTED
                break
        if status == INTERRUPTED:
            break
    if as_json:
        output_json(results if several else results[0])
    return status


def load_story(path: str, settings: tuple[tuple[str, str], ...] = ()) -> Story:
    """A checked story, with `--set` applied."""
    from i2pdsl.language.override import override
    from i2pdsl.language.statements import read_source
    from i2pdsl.pipeline import story_from

    source, folder = read_source(path), Path(path).parent
    if settings:
        known = tuple(story_from(source, folder).typed.vocabulary.settings)
        for name, value in settings:
            source = override(source, name, value, known)
    return story_from(source, folder)


def make(
    story: Story,
    seed: int,
    folder: Path,
    formats: tuple[str, ...],
    candidates: int,
    naive: bool,
    bars: Bars,
) -> tuple[dict[str, Any], bool]:
    """Solves one story and draws it; returns the document of `--json`, and whether all was done."""
    import time

    found = story.solve(seed, candidates, naive, bars.watch)
    if not found.finished:
        click.echo("interrupted: the best of what was searched so far is kept", err=True)
    if len(found.candidates) < candidates:
        count = len(found.candidates)
        click.echo(f"{count} script{'s' * (count != 1)} found that differ visibly", err=True)
    seconds = {"plan": 0.0, "compile": 0.0, "search": 0.0, "render": 0.0, **found.seconds}
    parts = []
    for number, script in enumerate(found.candidates, 1):
        place = folder if number == 1 else folder / f"candidate-{number}"
        path = script.save(place / "script.json")
        began = time.perf_counter()
        title = story.typed.name + (f", candidate {number}" if candidates > 1 else "")
        files = draw(script, place, formats, bars, title)
        seconds["render"] += time.perf_counter() - began
        parts.append({"score": script.score, "script": str(path), "files": files})
    document: dict[str, Any] = {
        "story": story.typed.name,
        "seed": seed,
        **parts[0],
        "seconds": {name: round(value, 4) for name, value in seconds.items()},
    }
    if candidates > 1:
        document["candidates"] = parts
    return document, found.finished


def draw(
    script: Script, folder: Path, formats: tuple[str, ...], bars: Bars, title: str | None = None
) -> dict[str, str]:
    """Writes the pictures; returns their paths by name."""
    from i2pdsl.render.pictures import Pictures

    files = Pictures(script, title).save(folder, formats, bars.drawing)
    bars.close()
    return {name: str(path) for name, path in files.items()}


def report(result: dict[str, Any]) -> None:
    """A result for people: where everything is."""
    for part in result.get("candidates", [result]):
        click.echo(f"{result['story']} (seed {result['seed']}): score {part['score']:.6g}")
        for path in (part["script"], *part["files"].values()):
            click.echo(f"  {path}")


@program.command()
@click.argument("script", type=click.Path())
@click.option(
    "--format", "formats", type=Formats(), default="png,html", help="png,svg,gif,mp4,html"
)
@click.option(
    "--out", type=click.Path(file_okay=False), default=None, help="Default: the script's."
)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def render(script: str, formats: tuple[str, ...], out: str | None, as_json: bool) -> None:
    """Draw the pictures of a finished script."""
    from i2pdsl.pipeline import Script
    from i2pdsl.progress import Bars

    with Bars() as bars:
        finished = Script.load(script, bars.watch)
        files = draw(finished, Path(out) if out else Path(script).parent, formats, bars)
    if as_json:
        output_json({"script": script, "files": files})
    else:
        for path in files.values():
            click.echo(path)


# Checking and formatting.


@program.command()
@click.argument("paths", nargs=-1, required=True, type=click.Path())
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def check(paths: tuple[str, ...], as_json: bool) -> int:
    """Check stories, libraries and worlds, or whole folders of them."""
    from i2pdsl.language.check import check_source
    from i2pdsl.language.statements import read_source
    from i2pdsl.worlds.find import find_vocabulary
    from i2pdsl.worlds.grid.parse import parse_world

    diagnostics: list[Diagnostic] = []
    files = [str(f) for path in paths for f in story_files(path)]
    for name in files:
        try:
            source = read_source(name)
            if name.endswith(".world"):
                parse_world(source, Path(name).stem)
            else:
                checked = check_source(source, find_vocabulary, Path(name).parent)
                diagnostics.extend(checked.warnings)
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


def story_files(path: str) -> list[Path]:
    """The file itself, or all stories and worlds of a folder."""
    place = Path(path)
    if not place.is_dir():
        return [place]
    found = sorted(p for kind in ("*.story", "*.world") for p in place.rglob(kind))
    if not found:
        raise error("no-file", "there are no stories in this folder", whole_file(path))
    return found


@program.command()
@click.argument("paths", nargs=-1, required=True, type=click.Path(allow_dash=True))
@click.option("--check", "only_check", is_flag=True, help="Change nothing; status 1 if it would.")
def fmt(paths: tuple[str, ...], only_check: bool) -> int:
    """Format stories in place ('-': from standard input to standard output)."""
    from i2pdsl.language.format import format_source
    from i2pdsl.language.statements import decode, read_source
    from i2pdsl.resources import write_text

    status = DONE
    for path in paths:
        if path == "-":
            source = decode(sys.stdin.buffer.read(), "standard input")
            click.echo(format_source(source), nl=False)
            continue
        for file in story_files(path):
            if file.suffix == ".world":
                continue
            source = read_source(file)
            text = format_source(source)
            if file.read_bytes() == text.encode():
                continue
            click.echo(str(file))
            if only_check:
                status = WRONG
            else:
                write_text(file, text)
    return status


# Asking.


@program.command()
@click.argument("source", type=click.Path())
@click.argument("expression")
@click.option("--assume", default=None, help="Another assumption; 'nothing' drops it.")
@click.option("--seed", type=click.IntRange(0), default=0, help="Where a story is given.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def query(source: str, expression: str, assume: str | None, seed: int, as_json: bool) -> None:
    """Evaluate one expression over a finished script, or over a story that is solved first."""
    from i2pdsl.progress import Bars

    with Bars() as bars:
        script = script_or_story(source, seed, bars)
        checked = script.check(expression, assume)
        show(checked.warnings)
        answer = script.answer(checked)
    if as_json:
        output_json({"expr": expression, "t": answer.t, "value": answer.as_json()})
    else:
        click.echo(show_answer(answer))


def script_or_story(path: str, seed: int, bars: Bars) -> Script:
    """A script file, or the script of a story that is solved now."""
    from i2pdsl.pipeline import Script

    if path.endswith(".story"):
        story = load_story(path)
        show(story.warnings)
        return story.solve(seed, watch=bars.watch).script
    return Script.load(path, bars.watch)


def show_answer(answer: Answer) -> str:
    """An answer for people: a number, a column over t, or a table of a latent's values."""
    import numpy as np

    number = lambda x: f"{float(x):.6g}"
    if answer.labels is None:
        if answer.t is None:
            return number(answer.value)
        return "\n".join(f"{t:>4} {number(v)}" for t, v in zip(answer.t, answer.value, strict=True))
    assert answer.unknown is not None
    names, table = list(answer.labels), answer.value
    if np.any(answer.unknown > 0):
        names.append("unknown")
        table = np.concatenate([table, answer.unknown[..., None]], axis=-1)
    if answer.t is None:
        width = max(map(len, names))
        return "\n".join(f"{n:<{width}} {number(v)}" for n, v in zip(names, table, strict=True))
    head = "   t " + " ".join(f"{n:>12}" for n in names)
    rows = (
        f"{t:>4} " + " ".join(f"{number(v):>12}" for v in row)
        for t, row in zip(answer.t, table, strict=True)
    )
    return "\n".join((head, *rows))


# What there is.


def complete_world(ctx: Any, param: Any, incomplete: str) -> list[str]:
    """Shell completion: the built-in worlds."""
    from i2pdsl.worlds.find import builtin_worlds

    return [name for name in builtin_worlds() if name.startswith(incomplete)]


def spec_of(name: str) -> Any:
    """A world by name or path. Raises StoryError."""
    from i2pdsl.errors import did_you_mean
    from i2pdsl.worlds.find import builtin_worlds, find_spec

    spec = find_spec(name, Path())
    if spec is None:
        hint = did_you_mean(name, builtin_worlds())
        raise error("no-world", f"there is no world `{name}`", whole_file(name), hint)
    return spec


@program.command()
@click.argument("name", required=False, shell_complete=complete_world)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def worlds(name: str | None, as_json: bool) -> None:
    """List the worlds, or describe one."""
    from i2pdsl.describe import describe_world, world_as_json
    from i2pdsl.worlds.find import builtin_worlds

    if name is not None:
        spec = spec_of(name)
        if as_json:
            output_json(world_as_json(spec))
        else:
            click.echo(describe_world(spec))
        return
    specs = [spec_of(world) for world in builtin_worlds()]
    if as_json:
        output_json([world_as_json(spec) for spec in specs])
        return
    width = max(len(spec.name) for spec in specs)
    for spec in specs:
        click.echo(f"{spec.name:<{width}}  {spec.documentation.partition(chr(10))[0]}")


@program.command()
@click.argument("library", required=False, type=click.Path())
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def patterns(library: str | None, as_json: bool) -> None:
    """List the standard patterns, or those of a library (a file or a folder)."""
    from i2pdsl.describe import library_patterns

    found = library_patterns(library)
    if as_json:
        output_json(found)
        return
    for number, pattern in enumerate(found):
        if number:
            click.echo()
        click.echo(pattern["signature"])
        for line in str(pattern["documentation"]).splitlines():
            click.echo(f"    {line}")


@program.command()
@click.argument("world", shell_complete=complete_world)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def plan(world: str, as_json: bool) -> None:
    """Solve a world's planning problem ahead of time and store it."""
    import time

    from i2pdsl.progress import Bars
    from i2pdsl.worlds.grid.world import build_world

    spec = spec_of(world)
    began = time.perf_counter()
    with Bars() as bars:
        built = build_world(spec, None, bars.watch.planning, bars.watch.say)
    problems = sum(table.shape[1] for table in built.tables.continuation)
    document = {
        "world": spec.name,
        "states": spec.state_count,
        "problems": problems,
        "residual": built.residual,
        "cached": built.planning_seconds == 0,
        "seconds": round(time.perf_counter() - began, 3),
    }
    if as_json:
        output_json(document)
        return
    where = "read from the cache" if document["cached"] else "solved and stored"
    click.echo(
        f"{spec.name}: {spec.state_count:,} states, {problems} problems, residual "
        f"{built.residual:.2g}, {where} in {document['seconds']:.1f} s"
    )


@program.command()
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
def completion(shell: str) -> None:
    """Print the completion script of a shell: eval "$(i2p completion bash)"."""
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    assert kind is not None
    click.echo(kind(program, {}, "i2p", "_I2P_COMPLETE").source())


if __name__ == "__main__":
    main()
