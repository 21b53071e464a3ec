"""The wheel has everything in it, and works where there is no checkout."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import zipfile
from functools import partial
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built without a network, by the backend that is installed."""
    pytest.importorskip("hatchling")
    folder = tmp_path_factory.mktemp("dist")
    build = [
        sys.executable,
        "-m",
        "build",
        "--wheel",
        "--no-isolation",
        "-o",
        str(folder),
        str(ROOT),
    ]
    done = subprocess.run(build, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    (file,) = folder.glob("*.whl")
    return file


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The unpacked wheel, as pip would leave it, on a path of its own; returns its folder."""
    folder = tmp_path_factory.mktemp("site")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return folder


def files_of(folder: str, *suffixes: str) -> set[str]:
    place = ROOT / folder
    return {p.relative_to(ROOT).as_posix() for p in place.rglob("*") if p.suffix in suffixes}


def test_the_wheel_holds_everything(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    wanted = files_of("i2pdsl", ".py", ".svg", ".html", ".css", ".js", ".gd", ".world")
    wanted |= {f"i2pdsl/data/{f}" for f in files_of("grammar", ".lark")}
    wanted |= {f"i2pdsl/data/{f}" for f in files_of("stories", ".story", ".world")}
    assert "i2pdsl/data/grammar/story.lark" in wanted
    assert "i2pdsl/data/stories/patterns/depict.story" in wanted
    assert "i2pdsl/worlds/sprites/robot.svg" in wanted
    assert "i2pdsl/render/page/player.js" in wanted
    assert wanted - names == set()
    strangers = {n for n in names if not n.startswith("i2pdsl")}
    assert strangers == set()
    assert not [n for n in names if "__pycache__" in n or n.startswith("i2pdsl/data/tests")]
    assert any(n.endswith("licenses/LICENSE") for n in names)


def test_the_wheel_declares_its_program(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        name = next(n for n in archive.namelist() if n.endswith("entry_points.txt"))
        assert "i2p = i2pdsl.cli:main" in archive.read(name).decode()
        name = next(n for n in archive.namelist() if n.endswith("METADATA"))
        metadata = archive.read(name).decode()
    for package in ("click", "jax", "lark", "matplotlib", "numpy", "pillow", "resvg-py", "tqdm"):
        assert f"Requires-Dist: {package}" in metadata


def run(installed: Path, folder: Path, *arguments: str) -> str:
    """Runs `i2p` from the unpacked wheel, far from the checkout."""
    # -P and -S keep out the folder itself and the editable install of the checkout.
    code = (
        "import sys, i2pdsl; assert i2pdsl.__file__.startswith(sys.argv.pop(1)), i2pdsl.__file__;"
        "from i2pdsl.cli import main; main()"
    )
    paths = [str(installed), sysconfig.get_path("purelib")]
    done = subprocess.run(
        [sys.executable, "-S", "-P", "-c", code, str(installed), *arguments],
        capture_output=True,
        text=True,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_wheel_works_outside_the_checkout(installed: Path, tmp_path: Path) -> None:
    story = "world kitchen\nlength 3\nmaximize depict(rho > 0)\n"
    (tmp_path / "my.story").write_text(story, encoding="utf-8")
    run(installed, tmp_path, "check", "my.story")
    assert "kitchen" in run(installed, tmp_path, "worlds")
    assert "depict(" in run(installed, tmp_path, "patterns")
    assert "208,860 states" in run(installed, tmp_path, "worlds", "kitchen")
    assert run(installed, tmp_path, "--version").startswith("i2p, version")
    assert [p.name for p in tmp_path.iterdir()] == ["my.story"]


def test_the_wheel_makes_and_draws_a_story(installed: Path, tmp_path: Path) -> None:
    """Grammar, world, patterns, sprites and page are all found in the wheel."""
    source = (ROOT / "stories" / "worlds" / "fork.world").read_text(encoding="utf-8")
    (tmp_path / "own.world").write_text(source, encoding="utf-8")
    (tmp_path / "my.story").write_text("world own\nlength 3\nsearch naive\n", encoding="utf-8")
    out = run(installed, tmp_path, "run", "my.story", "--format", "svg,html")
    assert len(out.splitlines()) == 5
    assert (tmp_path / "out" / "my" / "page.html").stat().st_size > 10_000


def test_the_wheel_is_installed_by_pip(wheel: Path, tmp_path: Path) -> None:
    """Into an environment of its own, whose dependencies are those of this one."""
    venv = [sys.executable, "-m", "venv", "--without-pip", str(tmp_path / "venv")]
    subprocess.run(venv, check=True)
    python = tmp_path / "venv" / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--python", str(python), "install", "--quiet"]
    subprocess.run([*pip, "--no-compile", "--no-deps", "--no-index", str(wheel)], check=True)
    (site,) = (tmp_path / "venv" / "lib").glob("python*/site-packages")
    # A path alone: the .pth file of the checkout's editable install is not read.
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    tool = tmp_path / "venv" / "bin" / "i2p"
    own = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    call = partial(subprocess.run, capture_output=True, text=True, cwd=tmp_path, env=own)
    for command in (["worlds"], ["patterns"], ["check", str(site / "i2pdsl/data/stories")]):
        done = call([tool, *command])
        assert done.returncode == 0, done.stderr
    where = call([python, "-c", "import i2pdsl; print(i2pdsl.__file__)"])
    assert where.stdout.startswith(str(site))
