"""Who may import or include what (docs/architecture.md): arrows point only down."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from imports import imported_modules

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "python" / "lfdcore"
CORE = ("geometry", "grid", "simulation", "planning", "control", "estimation", "primitives", "kinematics", "hardware")
FACADES = {"errors", *CORE}
BASE = FACADES | {"progress"}
MAY_IMPORT = {
    **{facade: {"_core"} for facade in FACADES},
    "progress": set(),
    "datasets": FACADES,
    "models": set(),
    "wheelchair": BASE | {"datasets"},
    "humanoid": BASE | {"datasets"},
    "simulated": BASE | {"datasets", "wheelchair", "humanoid"},
    "ros": BASE | {"datasets", "wheelchair"},
    "training": BASE | {"datasets", "wheelchair", "humanoid"},
    "pictures": BASE | {"datasets", "wheelchair", "humanoid", "simulated", "training"},
    "study": BASE | {"models", "datasets", "wheelchair", "humanoid", "simulated", "training", "pictures"},
    "cli": BASE | {"models", "ros", "datasets", "wheelchair", "humanoid", "simulated", "training", "pictures", "study"},
    "__main__": {"cli"},
}
VOCABULARY = {"error", "geometry", "path", "motion", "row_matrix"}
MAY_INCLUDE = {
    "grid": set(),
    "estimation": set(),
    "primitives": set(),
    "kinematics": set(),
    "planning": {"grid"},
    "control": {"grid"},
    "simulation": {"grid"},
    "hardware": {"grid"},
}


def modules() -> list[Path]:
    return sorted(p for p in PACKAGE.rglob("*.py") if p != PACKAGE / "__init__.py")


def stage(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported(path: Path) -> set[str]:
    """The lfdcore stages that a file imports anywhere, also inside functions and under TYPE_CHECKING."""
    return {name.split(".")[1] for name in imported_modules(path) if name.startswith("lfdcore.")}


def test_every_stage_is_in_the_table_and_no_other() -> None:
    there = {stage(path) for path in modules()} | {p.name for p in PACKAGE.iterdir() if (p / "__init__.py").exists()}
    assert there - {"_core"} == set(MAY_IMPORT)


def floors(of: str) -> dict[str, int]:
    """Each folder and file of a stage -> the length of the longest way down inside the stage."""
    below: dict[str, set[str]] = {}
    for path in (PACKAGE / of).rglob("[!_]*.py"):
        room = path.relative_to(PACKAGE / of).parts[0].removesuffix(".py")
        names = re.findall(rf"lfdcore\.{of}(?:\.| import )(\w+)", path.read_text())
        below.setdefault(room, set()).update(set(names) - {room})

    def floor(room: str, above: tuple[str, ...] = ()) -> int:
        assert room not in above, f"a circle of imports: {' -> '.join((*above, room))}"
        return 1 + max((floor(name, (*above, room)) for name in below[room] if name in below), default=0)

    return {room: floor(room) for room in below}


@pytest.mark.parametrize(
    "of", ["datasets", "wheelchair", "humanoid", "simulated", "ros", "training", "pictures", "study"]
)
def test_a_stage_has_no_circles_and_few_floors(of: str) -> None:
    assert max(floors(of).values()) <= (5 if of in ("wheelchair", "study") else 6), floors(of)


@pytest.mark.parametrize("path", sorted((PACKAGE / "study").rglob("*.py")), ids=lambda p: str(p.relative_to(PACKAGE)))
def test_no_file_of_a_study_is_over_400_lines(path: Path) -> None:
    assert len(path.read_text().splitlines()) <= 400


@pytest.mark.parametrize("path", modules(), ids=lambda p: str(p.relative_to(PACKAGE)))
def test_a_python_module_imports_only_from_its_own_stage_and_below(path: Path) -> None:
    own = stage(path)
    known = set(MAY_IMPORT) | {"_core", "__version__"}
    foreign = (imported(path) & known) - MAY_IMPORT[own] - {own, "__version__"}
    assert not foreign, f"{path.relative_to(ROOT)} imports {sorted(foreign)}"


@pytest.mark.parametrize("name", ["scene", "contact", "baxter", "arm"])
def test_scene_and_arm_lie_below_the_tasks(name: str) -> None:
    code = f"import sys, lfdcore.humanoid.{name}; print([m for m in sys.modules if 'covering' in m or 'passing' in m])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def cpp_files() -> list[Path]:
    files = [*ROOT.glob("cpp/include/lfdcore/**/*.hpp"), *ROOT.glob("cpp/src/**/*.?pp")]
    return sorted(p for p in files if "bindings" not in p.parts)


@pytest.mark.parametrize("path", cpp_files(), ids=lambda p: str(p.relative_to(ROOT)))
def test_a_cpp_file_includes_only_its_own_module_and_those_below(path: Path) -> None:
    text = path.read_text()
    assert "pybind11" not in text, "only cpp/src/bindings may include pybind11"
    own = path.parent.name
    for module, rest in re.findall(r'#include "lfdcore/(\w+)(/[^"]*)?', text):
        if rest:
            assert module == own or module in MAY_INCLUDE[own], f"{own} includes {module}{rest}"
        else:
            assert module in VOCABULARY


def test_importing_lfdcore_needs_neither_scipy_nor_matplotlib_nor_torch() -> None:
    facades = ", ".join(f"lfdcore.{name}" for name in sorted(FACADES))
    heavy = {"scipy", "sklearn", "matplotlib", "torch", "cv2", "onnx", "onnxruntime"}
    code = f"import sys, lfdcore, {facades}; print(sorted({heavy} & set(sys.modules)))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def test_no_module_needs_ros_until_a_node_is_made() -> None:
    names = [
        ".".join(("lfdcore", *p.relative_to(PACKAGE).with_suffix("").parts)) for p in modules() if "ros" in p.parts
    ]
    ros = {"rclpy", "sensor_msgs", "nav_msgs", "geometry_msgs", "std_msgs", "tf2_msgs"}
    code = f"import sys, lfdcore.cli.main, {', '.join(names)}; print(sorted({ros} & set(sys.modules)))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def test_only_the_node_imports_ros() -> None:
    for path in modules():
        if stage(path) != "ros":
            assert not imported_modules(path) & {"rclpy", "sensor_msgs.msg", "geometry_msgs.msg"}, path


@pytest.mark.parametrize("stage", ["wheelchair", "humanoid", "simulated", "pictures", "study"])
def test_only_training_needs_torch(stage: str) -> None:
    files = sorted((PACKAGE / stage).rglob("[!_]*.py"))
    names = [".".join(("lfdcore", *p.relative_to(PACKAGE).with_suffix("").parts)) for p in files]
    code = f"import sys, {', '.join(names)}; print(sorted({{'torch', 'onnx'}} & set(sys.modules)))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"
