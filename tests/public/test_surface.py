"""Names, keys and commands are those of `surface.json`: what differs is printed, and may break a caller's program.

`python -m tests.public write` writes the file anew, once the change is meant; it then belongs in the changelog.
"""

import copy

import pytest

from tests.public.answers import ANSWERS, COMMANDS, answer_keys, json_keys
from tests.public.commands import commands, file_keys
from tests.public.names import public_names
from tests.public.surface import FILE, differences, kept, written


def same(before, now):
    found = differences(before, now)
    assert not found, "\n".join(["python -m tests.public write, if this is meant:", *found])


def test_public_names_have_the_signatures_and_the_members_that_they_had():
    same(kept()["names"], public_names())


@pytest.mark.parametrize("name", ANSWERS)
def test_an_answer_has_the_keys_and_the_columns_that_it_had(name):
    same(kept()["answers"].get(name, {}), answer_keys(name))


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_prints_json_with_the_keys_that_it_had(name):
    same(kept()["json"].get(name, {}), json_keys(name))


def test_commands_take_what_they_took():
    same(kept()["commands"], commands())


def test_files_have_the_keys_that_they_had():
    same(kept()["files"], file_keys())


def test_the_file_has_the_answers_that_are_asked_and_no_others_and_reads_as_it_was_written():
    assert list(kept()["answers"]) == list(ANSWERS)
    assert list(kept()["json"]) == list(COMMANDS)
    assert FILE.read_text(encoding="utf-8") == written(kept())


def test_what_is_added_gone_or_changed_is_seen():
    before = kept()
    now = copy.deepcopy(before)
    del now["names"]["Grasp"]["solve"]
    now["names"]["Grasp"]["dissolve"] = "()"
    now["answers"]["a verdict, HELD"]["dictionary"]["word"] = "number"
    now["answers"]["margins"]["columns"].remove("share")
    now["commands"]["solve"]["--json"] = "Path"
    assert differences(before, before) == []
    assert differences(before, now) == [
        f"gone: names: Grasp: solve {before['names']['Grasp']['solve']}",
        "gone: answers: margins: columns: share ",
        "added: names: Grasp: dissolve ()",
        "changed: answers: a verdict, HELD: dictionary: word text is now number",
        "changed: commands: solve: --json flag is now Path",
    ]
