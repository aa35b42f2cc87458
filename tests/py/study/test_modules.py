"""What a report loads of our modules: its own machinery is small, and a study loads what it is about alone."""

import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).parents[3] / "python" / "lfdcore"
HANDWRITING = """
from pathlib import Path
import numpy as np
from lfdcore.datasets.lasa import Handwriting
from lfdcore.study.sequences.report import findings
from lfdcore.study.sequences.study import SequenceStudy, ask_in_draws
from lfdcore.study.study import write_study

paths = np.random.default_rng(0).normal(0, 10, (4, 6, 40, 2)).cumsum(axis=2)
shapes = [Handwriting(f"shape {k}", (np.arange(40.0),) * 6, tuple(six)) for k, six in enumerate(paths)]
study = SequenceStudy(data=Path("shapes"), draws=1, processes=1)
write_study(study, findings(ask_in_draws(study, shapes)), Path.cwd())
"""


def loaded(code: str, folder: Path) -> set[str]:
    """Our modules after `code`, without the packages that they lie in."""
    listing = "import sys\nprint(*(name for name in sys.modules if name.split('.')[0] == 'lfdcore'))"
    words = [sys.executable, "-c", f"{code}\n{listing}"]
    done = subprocess.run(words, capture_output=True, text=True, check=True, cwd=folder)
    return {name for name in done.stdout.split() if not (PACKAGE.parent / name.replace(".", "/")).is_dir()}


def test_the_reports_machinery_imports_two_others_of_our_modules(tmp_path: Path) -> None:
    page = "lfdcore.study.report.page"
    others = loaded(f"import {page}", tmp_path) - {page}
    assert others <= {"lfdcore.pictures.style", "lfdcore.study.report.table"}


def test_a_report_on_handwriting_loads_no_wheelchair(tmp_path: Path) -> None:
    modules = loaded(HANDWRITING, tmp_path)
    assert (tmp_path / "report.html").is_file()
    folders = {name.split(".")[1] for name in modules if name.count(".") > 1}
    assert not folders & {"wheelchair", "simulated", "humanoid", "training"}
    assert {name for name in modules if name.startswith("lfdcore.pictures")} == {"lfdcore.pictures.style"}
    studies = {name for name in modules if name.startswith("lfdcore.study.") and name.endswith(".study")}
    assert studies == {"lfdcore.study.study", "lfdcore.study.sequences.study"}
