"""What makes the package one that can be installed, cited and released says the same everywhere."""

import pathlib
import re
import subprocess
import tomllib

import pytest

import handlcp as hl

ROOT = pathlib.Path(__file__).parents[1]
PACKAGE = pathlib.Path(hl.__file__).parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
HIDDEN = sorted(p for folder in (".github", ".conda") for p in (ROOT / folder).rglob("*.y*ml"))
# Names that packages have on conda-forge where they differ from PyPI's
CONDA = {"pin": "pinocchio-python"}


def text(*parts):
    return ROOT.joinpath(*parts).read_text(encoding="utf-8")


def yaml(file):
    return pytest.importorskip("yaml", reason="comes with the extra test").safe_load(file.read_text(encoding="utf-8"))


def names(requirements):
    return {re.match(r"[\w-]+", r)[0].lower().replace("_", "-") for r in requirements}


def test_one_version_everywhere():
    version = hl.__version__
    assert re.fullmatch(r"\d+\.\d+\.\d+", version)
    cited = re.search(r"^version: (.*)\ndate-released: \"(.*)\"$", text("CITATION.cff"), re.M)
    first = re.search(r"^## (\S+), (\S+)$", text("CHANGELOG.md"), re.M)
    assert cited.groups() == first.groups()
    assert cited[1] == version
    recipe = re.search(r"^  version: \"(.*)\"$", text(".conda", "recipe.yaml"), re.M)
    assert recipe[1] == version
    assert "version" in PROJECT["dynamic"], "handlcp/version.py has it"


def test_nothing_that_a_run_leaves_behind_is_in_the_root_of_the_repository():
    """MuJoCo appends its warnings to MUJOCO_LOG.TXT in the working folder where nobody takes them."""
    assert "MUJOCO_LOG.TXT" in text(".gitignore").splitlines()
    done = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        pytest.skip("no checkout")
    files = {file for file in done.stdout.splitlines() if "/" not in file}
    known = {".gitignore", "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "LICENSE", "README.md", "pyproject.toml"}
    assert files <= known


def test_the_changelog_has_a_section_for_each_version_the_newest_first():
    versions = re.findall(r"^## (.*)$", text("CHANGELOG.md"), re.M)
    assert all(re.fullmatch(r"\d+\.\d+\.\d+, \d{4}-\d\d-\d\d", v) for v in versions)
    numbers = [tuple(map(int, v.partition(",")[0].split("."))) for v in versions]
    assert numbers == sorted(numbers, reverse=True)


def test_the_citation_is_well_formed_and_invents_no_doi():
    cited = yaml(ROOT / "CITATION.cff")
    assert {"cff-version", "message", "title", "authors", "version", "license"} <= set(cited)
    assert "doi" not in cited, "nobody has given it one"
    assert cited["license"] == PROJECT["license"]


@pytest.mark.parametrize("file", HIDDEN, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_files_for_other_machines_are_yaml(file):
    assert isinstance(yaml(file), dict)


def test_workflows_run_what_is_there_on_the_pythons_that_are_promised():
    workflows = {p.name: yaml(p) for p in HIDDEN if p.parent.name == "workflows"}
    steps = [s for w in workflows.values() for job in w["jobs"].values() for s in job.get("steps", ())]
    scripts = {name for s in steps for name in re.findall(r"bash (\S+)", s.get("run", ""))}
    assert scripts == {".ci/extras", ".ci/run", ".ci/suite", ".ci/wheel"}
    assert all((ROOT / name).is_file() for name in scripts)
    jobs = workflows["ci.yml"]["jobs"]
    first = [s["with"]["python-version"] for s in jobs["everything"]["steps"] if "python-version" in s.get("with", {})]
    promised = {c.rpartition(" ")[2] for c in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", c)}
    assert {*first, *jobs["python"]["strategy"]["matrix"]["python"]} == promised
    assert set(jobs["wheels"]["strategy"]["matrix"]["python"]) == promised
    assert PROJECT["requires-python"] == f">={min(promised)}"


def test_the_conda_recipe_asks_for_what_the_package_asks_for():
    run = yaml(ROOT / ".conda" / "recipe.yaml")["requirements"]["run"]
    asked = names(r for r in run if not r.startswith("python"))
    assert asked - {"coal-python"} == {
        CONDA.get(name, name).replace("_", "-") for name in names(PROJECT["dependencies"])
    }
    bounds = {re.match(r"[\w-]+", r)[0]: r.partition(">=")[2] for r in PROJECT["dependencies"]}
    for name, least in bounds.items():
        assert f"{CONDA.get(name, name)} >={least}" in run


def test_every_extra_is_tried_alone_by_the_command_for_that():
    tried = re.findall(r"^  (\w+)\)", text(".ci", "extras"), re.M)
    assert sorted(tried) == sorted(PROJECT["optional-dependencies"])
