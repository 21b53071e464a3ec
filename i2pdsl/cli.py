"""The command `i2p`: arguments in, results on standard output, messages on standard error.

Exit status (interfaces.md): 0 done, 1 the story, world or script is wrong, 2 wrong usage,
130 interrupted.
"""

from __future__ import annotations

import errno
import json
import math
import os
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from i2pdsl.errors import Diagnostic, Source, StoryError, error, whole_file

if TYPE_CHECKING:
    from i2pdsl.pipeline import Answer, Script, Story

DONE, WRONG, USAGE, INTERRUPTED = 0, 1, 2, 130


def main(arguments: list[str] | None = None) -> None:
    """The program."""
    sys.unraisablehook = keep_interrupt
    status = run_command(arguments)
    if status == INTERRUPTED:
        # JAX may still be computing: to take Python down around its threads crashes (SIGSEGV).
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError, AttributeError):
                stream.flush()
        os._exit(status)
    sys.exit(status)


def keep_interrupt(lost: sys.UnraisableHookArgs) -> None:
    """Sends Ctrl-C again where Python would drop it: in JAX's callback of the garbage collector."""
    if not issubclass(lost.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(lost)
        return
    import signal
    import threading

    main_thread = threading.main_thread().ident
    again = threading.Timer(0.02, signal.pthread_kill, (main_thread, signal.SIGINT))
    again.daemon = True
    again.start()


def run_command(arguments: list[str] | None = None) -> int:
    """Runs one command; returns the exit status."""
    if "_I2P_COMPLETE" in os.environ:
        program.main(prog_name="i2p")  # a shell asks how the line may go on; exits
    arguments = sys.argv[1:] if arguments is None else arguments
    try:
        with program.make_context("i2p", list(arguments)) as context:
            result = program.invoke(context)
        return result if isinstance(result, int) else DONE
    except click.exceptions.Exit as leaving:
        return leaving.exit_code
    except StoryError as problem:
        show(problem.diagnostics)
        return WRONG
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        return INTERRUPTED
    except click.ClickException as problem:
        problem.show()
        return USAGE
    except BrokenPipeError:
        forget_output()  # whoever read our output has had enough
        return DONE
    except (OSError, MemoryError) as problem:
        forget_output()
        with suppress(OSError):
            click.echo(f"error: {in_words(problem)}", err=True)
        return WRONG


def in_words(problem: OSError | MemoryError) -> str:
    """What the machine refuses (a full disk, a folder that cannot be written to), on one line."""
    if isinstance(problem, MemoryError):
        return "there is not enough memory"
    what = " ".join((problem.strerror or str(problem) or type(problem).__name__).split())
    name = problem.filename2 or problem.filename
    return f"{what}: {name}" if name else what


def forget_output() -> None:
    """Lets standard output end in nothing: flushing what is left in it would fail once more."""
    with suppress(OSError, ValueError, AttributeError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def show(diagnostics: tuple[Diagnostic, ...] | list[Diagnostic]) -> None:
    """Diagnostics as people read them, on standard error."""
    for diagnostic in diagnostics:
        click.echo(diagnostic.render(), err=True)


def output_json(document: Any) -> None:
    """The one document of `--json`. Infinities and NaN, which JSON has not, become null."""
    try:
        text = json.dumps(document, ensure_ascii=False, allow_nan=False)
    except ValueError:
        text = json.dumps(finite(document), ensure_ascii=False)
    encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
    try:
        text.encode(encoding)
    except UnicodeEncodeError:  # a terminal without Unicode, or a file name that is not UTF-8
        text = json.dumps(finite(document))
    click.echo(text)


def finite(value: Any) -> Any:
    """Plain data with null for numbers that are infinite or undefined."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    return [finite(item) for item in value] if isinstance(value, list) else value


def output(text: str) -> None:
    """A result for people; characters that the terminal does not have are spelt out."""
    encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
    click.echo(text.encode(encoding, "backslashreplace").decode(encoding))


class Seeds(click.ParamType):
    """`0-19`, `3` or `1,4,7`."""

    name = "seeds"

    def convert(self, value: Any, param: Any, ctx: Any) -> list[int]:
        seeds: list[int] = []
        for part in str(value).split(","):
            first, dash, last = part.strip().partition("-")
            numbers = [first, last] if dash else [first]
            if not all(number.isdecimal() and len(number) < 19 for number in numbers):
                self.fail(f"{value!r} are no seeds; write 0-19 or 1,4,7", param, ctx)
            span = range(int(numbers[0]), int(numbers[-1]) + 1)
            if not span or len(span) > 10_000:
                self.fail(f"{part!r} is an empty or endless range", param, ctx)
            seeds.extend(span)
        return list(dict.fromkeys(seeds))


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
    "--seed",
    type=click.IntRange(0),
    default=None,
    help="Of the initial states, or a descent's first changes; default 0.",
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
    "--candidates", type=click.IntRange(1, 100), default=1, help="So many different scripts."
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
    if seed is not None and seeds is not None:
        raise click.UsageError("give --seed or --seeds, not both")
    chosen = seeds if seeds is not None else [seed or 0]
    several = len(stories) > 1 or len(chosen) > 1 or seeds is not None
    loaded = load_stories(stories, settings)
    folders = [Path(out) / folder_name(story) for story in loaded]
    for folder in folders:
        if folders.count(folder) > 1:
            message = f"two stories would go into {folder}; run them with different --out"
            raise click.UsageError(message)
        check_writable(folder)
    results: list[dict[str, Any]] = []
    status = DONE
    for story, folder in zip(loaded, folders, strict=True):
        show(story.warnings)
        for number in chosen:
            place = folder / f"seed-{number}" if len(chosen) > 1 else folder
            try:
                result, finished = make(story, number, place, formats, candidates, naive)
            except StoryError as problem:
                show(problem.diagnostics)
                status = WRONG
                break
            except OSError as problem:  # the disk is full
                click.echo(f"error: {in_words(problem)}", err=True)
                status = WRONG
                break
            except KeyboardInterrupt:
                click.echo(f"interrupted: nothing was found yet for {story.typed.name}", err=True)
                status = INTERRUPTED
                break
            results.append(result)
            if not as_json:
                report(result)
            if not finished:
                status = INTERRUPTED
                break
        if status == INTERRUPTED:
            break
    if as_json and (several or results):
        output_json(results if several else results[0])
    return status


def load_stories(paths: tuple[str, ...], settings: tuple[tuple[str, str], ...]) -> list[Story]:
    """The checked stories. Raises StoryError with the mistakes of all of them."""
    loaded: list[Story] = []
    problems: list[Diagnostic] = []
    for path in dict.fromkeys(paths):
        try:
            loaded.append(load_story(path, settings))
        except StoryError as problem:
            problems.extend(problem.diagnostics)
    if problems:
        raise StoryError(problems)
    return loaded


def folder_name(story: Story) -> str:
    """The name of a story as that of a folder: never one that leads elsewhere."""
    name = story.typed.name
    return name if name.strip(".") else "story"


def check_writable(folder: Path) -> None:
    """Says that nothing can be written to a folder before the work rather than after it."""
    place = next((p for p in (folder, *folder.parents) if p.exists()), Path())
    if not place.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, "is no folder", str(place))
    if not os.access(place, os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, "cannot be written to", str(place))


def load_story(path: str, settings: tuple[tuple[str, str], ...] = ()) -> Story:
    """A checked story, with `--set` applied."""
    from i2pdsl.language.override import override
    from i2pdsl.language.statements import read_source
    from i2pdsl.pipeline import story_from

    source, folder = read_source(path), Path(path).parent
    if is_script(source):
        hint = "`i2p render` draws it, `i2p query` asks about it"
        message = "this is a finished script, not a story"
        raise error("not-a-story", message, whole_file(path), hint)
    if settings:
        words = story_from(source, folder).typed.vocabulary
        method = "beam" if words.enumerable else "descend"
        for name, value in settings:
            source = override(source, name, value, tuple(words.settings), method)
    return story_from(source, folder)


def prefetch(formats: tuple[str, ...]) -> None:
    """Imports what the plots need while the search computes: it takes as long as the search."""
    if {"png", "svg"} & set(formats):
        from threading import Thread

        work = "matplotlib.backends.backend_agg"
        Thread(target=lambda: import_module(work), daemon=True).start()


def make(
    story: Story,
    seed: int,
    folder: Path,
    formats: tuple[str, ...],
    candidates: int,
    naive: bool,
) -> tuple[dict[str, Any], bool]:
    """Solves one story and draws it; returns the document of `--json`, and whether all was done.

    Raises KeyboardInterrupt if it is interrupted before anything was found.
    """
    import time

    from i2pdsl.progress import Bars

    prefetch(formats)
    with Bars() as bars:
        found = story.solve(seed, candidates, naive, bars.watch)
    finished = found.finished
    if not finished:
        click.echo("interrupted: the best of what was searched so far is kept", err=True)
    chosen = found.candidates[:candidates]  # a descent found more
    if len(chosen) < candidates:
        count = len(chosen)
        alike = " that differ visibly" if story.typed.vocabulary.enumerable else ""
        click.echo(f"{count} script{'s' * (count != 1)} found{alike}", err=True)
    seconds = {"plan": 0.0, "compile": 0.0, "search": 0.0, "render": 0.0, **found.seconds}
    parts: list[dict[str, Any]] = []
    for number, script in enumerate(chosen, 1):
        place = folder if number == 1 else folder / f"candidate-{number}"
        path = script.save(place / "script.json")
        parts.append({"score": script.score, "script": str(path), "files": {}})
    began = time.perf_counter()
    try:
        for number, (script, part) in enumerate(zip(chosen, parts, strict=True), 1):
            place = Path(part["script"]).parent
            title = story.typed.name + (f", candidate {number}" if candidates > 1 else "")
            draw([script], place, formats, part["files"], title)
    except KeyboardInterrupt:
        click.echo("interrupted: the script is kept, not all its pictures are drawn", err=True)
        finished = False
    seconds["render"] = time.perf_counter() - began
    document: dict[str, Any] = {
        "story": story.typed.name,
        "seed": seed,
        **parts[0],
        "seconds": {name: round(value, 4) for name, value in seconds.items()},
    }
    if candidates > 1:
        document["candidates"] = parts
    return document, finished


def draw(
    scripts: list[Script],
    folder: Path,
    formats: tuple[str, ...],
    files: dict[str, str],
    title: str | None = None,
) -> None:
    """Writes the pictures; their paths are put into `files` as they are finished."""
    if not formats:
        return
    from i2pdsl.progress import Bars
    from i2pdsl.render.pictures import pictures_of

    pictures = pictures_of(scripts, title)
    with Bars() as bars:
        try:
            for name, path in pictures.drawn(folder, formats, bars.drawing):
                files[name] = str(path)
        except RuntimeError as problem:  # of ffmpeg: a full disk, most likely
            raise OSError(str(problem)) from problem


def report(result: dict[str, Any]) -> None:
    """A result for people: where everything is."""
    for part in result.get("candidates", [result]):
        score = "unknown" if part["score"] is None else f"{part['score']:.6g}"
        output(f"{result['story']} (seed {result['seed']}): score {score}")
        for path in (part["script"], *part["files"].values()):
            output(f"  {path}")


@program.command()
@click.argument("scripts", nargs=-1, required=True, type=click.Path())
@click.option(
    "--format", "formats", type=Formats(), default="png,html", help="png,svg,gif,mp4,html"
)
@click.option(
    "--out", type=click.Path(file_okay=False), help="Folder; default: the script's, or in out/."
)
@click.option("--seed", type=click.IntRange(0), default=0, help="Where a story is given.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def render(
    scripts: tuple[str, ...], formats: tuple[str, ...], out: str | None, seed: int, as_json: bool
) -> int:
    """Draw the pictures of a finished script, or of a story that is solved first.

    Several scripts of the hill are drawn side by side, in the same time.
    """
    if out is not None:
        check_writable(Path(out))
    status, solved = DONE, []
    for name in scripts:
        found, ended = script_or_story(name, seed)
        solved.append(found)
        status = max(status, ended)
    if len(solved) > 1:
        beside = Path("out", "together")
    elif solved[0].record.where == scripts[0]:
        beside = Path(scripts[0]).parent
    else:
        beside = Path("out", str(solved[0].record.story["name"]))
    folder = Path(out) if out is not None else beside
    files: dict[str, str] = {}
    try:
        draw(solved, folder, formats, files)
    except KeyboardInterrupt:
        click.echo("interrupted: not all pictures are drawn", err=True)
        status = INTERRUPTED
    if as_json:
        shown = scripts[0] if len(scripts) == 1 else list(scripts)
        output_json({"script": shown, "files": files})
    else:
        for path in files.values():
            output(path)
    return status


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
    files: list[str] = []
    for path in paths:
        try:
            files += [str(f) for f in story_files(path)]
        except StoryError as problem:
            diagnostics.extend(problem.diagnostics)
    files = list(dict.fromkeys(files))
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
    """The file itself, or all stories and worlds of a folder and those in it, but hidden ones."""
    place = Path(path)
    if not place.is_dir():
        return [place]
    found = []
    for folder, inner, names in os.walk(place):
        inner[:] = [name for name in inner if not name.startswith(".")]
        found += [Path(folder, name) for name in names if name.endswith((".story", ".world"))]
    if not found:
        raise error("no-file", "there are no stories in this folder", whole_file(path))
    return sorted(found)


@program.command()
@click.argument("paths", nargs=-1, required=True, type=click.Path(allow_dash=True))
@click.option("--check", "only_check", is_flag=True, help="Change nothing; status 1 if it would.")
def fmt(paths: tuple[str, ...], only_check: bool) -> int:
    """Format stories and worlds in place ('-': from standard input to standard output)."""
    from i2pdsl.language.format import format_source
    from i2pdsl.language.statements import decode, read_source
    from i2pdsl.resources import write_text
    from i2pdsl.worlds.grid.blocks import format_world

    status = DONE
    for path in paths:
        if path == "-":
            source = decode(sys.stdin.buffer.read(), "standard input")
            click.echo(format_source(source), nl=False)
            continue
        for file in story_files(path):
            form = format_world if file.suffix == ".world" else format_source
            text = form(read_source(file))
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
def query(source: str, expression: str, assume: str | None, seed: int, as_json: bool) -> int:
    """Evaluate one expression over a finished script, or over a story that is solved first."""
    script, status = script_or_story(source, seed)
    checked = script.check(expression, assume)
    show(checked.warnings)
    answer = script.answer(checked)
    if as_json:
        output_json({"expr": expression, "t": answer.t, "value": answer.as_json()})
    else:
        output(show_answer(answer))
    return status


def script_or_story(path: str, seed: int) -> tuple[Script, int]:
    """A script file, or the script of a story that is solved now; and the exit status.

    Raises KeyboardInterrupt if it is interrupted before a script was found.
    """
    from i2pdsl.language.statements import read_source
    from i2pdsl.pipeline import Script
    from i2pdsl.progress import Bars

    with Bars() as bars:
        if not path.endswith(".story") and is_script(read_source(path)):
            script = Script.load(path, bars.watch)
            show(script.warnings)
            return script, DONE
        story = load_story(path)
        show(story.warnings)
        found = story.solve(seed, watch=bars.watch)
    if not found.finished:
        click.echo("interrupted: the best of what was searched so far is used", err=True)
    return found.script, DONE if found.finished else INTERRUPTED


def is_script(source: Source) -> bool:
    """Whether a text is meant as a script: JSON, or in a file of that name."""
    return source.name.endswith(".json") or source.text.lstrip().startswith("{")


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
            output(describe_world(spec))
        return
    specs = [spec_of(world) for world in builtin_worlds()]
    if as_json:
        output_json([world_as_json(spec) for spec in specs])
        return
    width = max(len(spec.name) for spec in specs)
    for spec in specs:
        output(f"{spec.name:<{width}}  {spec.documentation.partition(chr(10))[0]}")


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
            output("")
        output(pattern["signature"])
        for line in str(pattern["documentation"]).splitlines():
            output(f"    {line}")


@program.command()
@click.argument("world", shell_complete=complete_world)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def plan(world: str, as_json: bool) -> None:
    """Solve a world's planning problem ahead of time and store it."""
    import time

    from i2pdsl.progress import Bars
    from i2pdsl.worlds.grid.world import build_world
    from i2pdsl.worlds.hill.spec import HillSpec

    spec = spec_of(world)
    if isinstance(spec, HillSpec):
        message = f"world {spec.name} is not planned but trained"
        raise error("no-plan", message, whole_file(world), f"`i2p train {spec.name}`")
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
    output(
        f"{spec.name}: {spec.state_count:,} states, {problems} problems, residual "
        f"{built.residual:.2g}, {where} in {document['seconds']:.1f} s"
    )


@program.command()
@click.argument("world", shell_complete=complete_world)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**31 - 2),
    default=None,
    help="Default: the world's `controller`.",
)
@click.option("--set", "settings", type=Assignment(), multiple=True, help="Of the world.")
@click.option("--iterations", type=click.IntRange(1), default=None, help="Default 2400.")
@click.option("--out", type=click.Path(file_okay=False), help="Folder; default: the cache.")
@click.option("--restart", is_flag=True, help="Do not go on from an interrupted training.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def train(
    world: str,
    seed: int | None,
    settings: tuple[tuple[str, str], ...],
    iterations: int | None,
    out: str | None,
    restart: bool,
    as_json: bool,
) -> int:
    """Train the controllers of a physics world and store them.

    Ctrl-C keeps the best so far; the same command goes on from there.
    """
    from i2pdsl.worlds.hill.spec import HillSpec

    spec = spec_of(world)
    if not isinstance(spec, HillSpec):
        message = f"world {spec.name} is not trained but planned"
        raise error("no-training", message, whole_file(world), f"`i2p plan {spec.name}`")
    spec = spec.with_settings(world_settings(spec, settings, spec.training_settings))
    seed = spec.settings.controller if seed is None else seed
    if out is not None:
        check_writable(Path(out))
    from i2pdsl.planning.actor_critic import Recipe
    from i2pdsl.progress import Bars
    from i2pdsl.worlds.hill.training import train_hill

    recipe = Recipe() if iterations is None else Recipe(iterations=iterations)
    with Bars() as bars:
        folder = None if out is None else Path(out)
        done = train_hill(spec, seed, folder, recipe, not restart, bars.training, bars.say)
    if not done.finished:
        click.echo("interrupted: the best so far is kept; the same command goes on", err=True)
    weights = done.controllers.weights
    document = {
        "world": spec.name,
        "seed": seed,
        "weights": list(weights),
        "iterations": done.controllers.about["iterations"],
        "reward": done.look.reward,
        "falls": done.look.falls,
        "climbs": list(done.look.climbs),
        "controllers": None if done.path is None else str(done.path),
        "finished": done.finished,
        "seconds": round(done.seconds, 1),
    }
    if as_json:
        output_json(document)
    else:
        climbs = ", ".join(
            f"weight {w:g} {c:.1f}" for w, c in zip(weights, done.look.climbs, strict=True)
        )
        output(
            f"{spec.name} (seed {seed}): the box goes up {climbs} units in 800 frames; "
            f"{100 * done.look.falls:.1f} % of the rollouts fall; {done.seconds:.0f} s"
        )
        if done.path is not None:
            output(f"  {done.path}")
    return DONE if done.finished else INTERRUPTED


def world_settings(
    spec: Any, given: tuple[tuple[str, str], ...], usable: tuple[str, ...]
) -> dict[str, Any]:
    """The values of `--set` for a world, of the settings that matter. Raises StoryError."""
    from i2pdsl.errors import did_you_mean
    from i2pdsl.worlds.find import vocabulary_of

    known = vocabulary_of(spec).settings
    found: dict[str, Any] = {}
    for name, text in given:
        where = whole_file(f"--set {name}")
        if name not in known:
            hint = did_you_mean(name, known) or "settings: " + ", ".join(usable)
            raise error("setting", f"`world {spec.name}` has no setting `{name}`", where, hint)
        if name not in usable:
            message = f"training does not depend on `{name}`"
            raise error("setting", message, where, "settings: " + ", ".join(usable))
        value: Any = text
        with suppress(ValueError):
            value = float(text)
        if text.startswith("{") and text.endswith("}"):
            with suppress(ValueError):
                value = tuple(float(part) for part in text[1:-1].split(","))
        if not known[name].holds(value):
            message = f"`{name}` cannot be {text}"
            raise error("setting", message, where, f"it can be: {known[name].possible}")
        found[name] = value
    return found


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
