"""What a run was made on, and with which code."""

from __future__ import annotations

import functools
import hashlib
import os
import platform
import sys
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

_UNRELATED = {"bench", "cli", "plot", "render"}  # changing a report changes no run
_SUFFIXES = (".py", ".lark", ".json")
_PACKAGES = ("stlc", "numpy", "scipy", "highspy", "pyscipopt", "mip", "pulp", "cvxpy", "gurobipy")


@functools.cache
def fingerprint() -> str:
    """Hash (16 hex digits) of the package's sources, as far as they decide what a run does."""
    root = Path(__file__).resolve().parent.parent
    total = hashlib.sha256()
    for path in sorted(_sources(root)):
        total.update(str(path.relative_to(root)).encode() + b"\0" + path.read_bytes())
    return total.hexdigest()[:16]


def _sources(root: Path) -> list[Path]:
    found = []
    for folder, inner, names in os.walk(root, followlinks=True):
        if Path(folder) == root:
            inner[:] = [name for name in inner if name not in _UNRELATED]
        inner[:] = [name for name in inner if name != "__pycache__"]
        found += [Path(folder, name) for name in names if name.endswith(_SUFFIXES)]
    return found


@functools.cache
def versions() -> str:
    """Python and the packages that matter, such as 'Python 3.12.1, stlc 0.1.0, numpy 2.0'."""
    found = [f"Python {platform.python_version()}"]
    for name in _PACKAGES:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            continue
    return ", ".join(found)


@functools.cache
def processor() -> str:
    """Model, number of logical processors, operating system."""
    name = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.is_file():
        lines = info.read_text(errors="replace").splitlines()
        models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
        name = models[0] if models else name
    return f"{name}, {os.cpu_count()} logical processors, {platform.system()}"


def load() -> float | None:
    """1-minute load average, where the system has one."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def cpu_seconds() -> float:
    """Processor time of this process, all its threads, and of the children it waited for."""
    times = os.times()
    return time.process_time() + times.children_user + times.children_system


def peak_memory() -> int | None:
    """Bytes that this process (or the largest of its children) has held at most."""
    try:
        import resource
    except ImportError:
        return None
    unit = 1 if sys.platform == "darwin" else 1024
    who = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return max(resource.getrusage(one).ru_maxrss for one in who) * unit
