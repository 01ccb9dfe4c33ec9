"""The tutorial notebook: its cells run, in order, and print what is stored beside them."""

import contextlib
import io
import json
import os
import pathlib

from tests.docs.blocks import lines
from tests.support.texts import WRITE

FILE = pathlib.Path(__file__).parents[2] / "docs" / "tutorial.ipynb"


def test_the_cells_of_the_tutorial_print_what_stands_below_them(tmp_path, monkeypatch):
    """With HANDLCP_WRITE_TEXTS=1 what is printed is written into the notebook."""
    monkeypatch.chdir(tmp_path)
    book, space = json.loads(FILE.read_text(encoding="utf-8")), {"__name__": "__main__"}
    cells = [cell for cell in book["cells"] if cell["cell_type"] == "code"]
    assert len(cells) > 4
    for number, cell in enumerate(cells, 1):
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(compile("".join(cell["source"]), f"cell {number}", "exec"), space)
        if os.environ.get(WRITE) == "1":
            text = out.getvalue().splitlines(keepends=True)
            stream = {"name": "stdout", "output_type": "stream", "text": text}
            cell["outputs"], cell["execution_count"] = [stream] if text else [], number
        shown = "".join(line for output in cell["outputs"] for line in output["text"])
        assert lines(shown) == lines(out.getvalue()), f"cell {number} prints\n{out.getvalue()}"
    if os.environ.get(WRITE) == "1":
        FILE.write_text(json.dumps(book, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    assert (tmp_path / "cube.png").stat().st_size > 10_000
