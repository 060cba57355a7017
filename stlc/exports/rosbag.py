"""ROS 2 bags, written without ROS: paths, and set points that come when they are due.

A bag is a folder (SQLite storage, which every ROS 2 plays: `ros2 bag play plan.rosbag`). Times
count from 0; whoever plays the bag chooses when that is.
"""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from stlc.arrays import Floats
from stlc.errors import OutputError, UsageError
from stlc.exports.track import FRAME, Tracks, nano, tracks
from stlc.files import reason
from stlc.mission import Mission
from stlc.plan import Plan

PATH = "nav_msgs/msg/Path"
POSE = "geometry_msgs/msg/PoseStamped"
TWIST = "geometry_msgs/msg/TwistStamped"
_VERSION: Final = 8
"""Of a bag's metadata: the oldest that rosbags writes, for the oldest players."""

Message = tuple[int, str, str, Any]
"""Nanoseconds, topic, type, content."""


def write_rosbag(
    mission: Mission, plan: Plan, path: str | os.PathLike[str], every: float | None
) -> None:
    """`/agents/NAME/path` at once; `/agents/NAME/pose` and `/agents/NAME/velocity` in time.

    UsageError where something has that name already, as `ros2 bag record` does, or `rosbags` is
    missing; OutputError when the folder can't be written, which leaves nothing behind.
    """
    try:
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise UsageError("ROS bags need a package: pip install 'stlc[rosbag]'") from None
    target = Path(path)
    if target.exists():
        raise UsageError(f"{target} is there already; a bag never takes another one's place")
    store = get_typestore(Stores.ROS2_HUMBLE)
    messages = sorted(_messages(tracks(mission, plan, every), plan.step, store.types),
                      key=lambda m: m[0])  # fmt: skip
    scratch = target.with_name(f".stlc-{secrets.token_hex(8)}.tmp")
    try:
        _write(scratch / target.name, store, messages)
        os.replace(scratch / target.name, target)
    except OSError as error:
        raise OutputError(f"cannot write {target}: {reason(error)}") from error
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _write(folder: Path, store: Any, messages: list[Message]) -> None:
    """The bag; paths are kept for those who listen later."""
    from rosbags.interfaces import (
        Qos,
        QosDurability,
        QosHistory,
        QosLiveliness,
        QosReliability,
        QosTime,
    )
    from rosbags.rosbag2 import Writer

    never = QosTime(0, 0)
    kept = Qos(QosHistory.KEEP_LAST, 1, QosReliability.RELIABLE, QosDurability.TRANSIENT_LOCAL,
               never, never, QosLiveliness.AUTOMATIC, never, False)  # fmt: skip
    folder.parent.mkdir()
    with Writer(folder, version=_VERSION) as writer:
        topics: dict[str, Any] = {}
        for time, topic, kind, content in messages:
            if topic not in topics:
                profiles = [kept] if kind == PATH else []
                topics[topic] = writer.add_connection(
                    topic, kind, typestore=store, offered_qos_profiles=profiles
                )
            writer.write(topics[topic], time, bytes(store.serialize_cdr(content, kind)))


def _messages(found: Tracks, step: float, types: Any) -> Iterator[Message]:
    """Of all agents: every pose of a path has the time at which it is due."""
    point, turn = types["geometry_msgs/msg/Point"], types["geometry_msgs/msg/Quaternion"]
    pose, stamped = types["geometry_msgs/msg/Pose"], types[POSE]
    vector, twist = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Twist"]
    for name, places in found.places.items():
        headings = found.headings(name, step)
        due = []
        for time, place, speed, heading in zip(
            found.times, places, found.speeds(name, step), headings, strict=True
        ):
            at, header = nano(time), _header(types, float(time))
            facing = turn(0.0, 0.0, float(np.sin(heading / 2)), float(np.cos(heading / 2)))
            due.append(stamped(header, pose(point(*_three(place)), facing)))
            moving = twist(vector(*_three(speed)), vector(0.0, 0.0, 0.0))
            yield at, f"/agents/{name}/pose", POSE, due[-1]
            yield at, f"/agents/{name}/velocity", TWIST, types[TWIST](header, moving)
        yield 0, f"/agents/{name}/path", PATH, types[PATH](_header(types, 0.0), due)


def _header(types: Any, seconds: float) -> Any:
    whole, rest = divmod(nano(seconds), 10**9)
    stamp = types["builtin_interfaces/msg/Time"](whole, rest)
    return types["std_msgs/msg/Header"](stamp, FRAME)


def _three(values: Floats) -> tuple[float, float, float]:
    x, y, *z = (float(v) for v in values)
    return x, y, z[0] if z else 0.0
