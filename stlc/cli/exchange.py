"""`stlc export` and `stlc map`: plans for other programs, maps from them."""

from __future__ import annotations

from pathlib import Path

import click

from stlc.cli.common import check_outputs, mission_options
from stlc.cli.lengths import metres, seconds
from stlc.cli.planned import load_planned


@click.command("export")
@mission_options
@click.argument("plan", type=click.Path(path_type=Path))
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path),
              help="By its ending: .geojson, .mcap, .rosbag, or .csv: waypoints.")  # fmt: skip
@click.option("--every", callback=seconds, metavar="TIME",
              help="Between samples, such as '100 ms'; else a step.")  # fmt: skip
def export_command(
    file: Path,
    plan: Path,
    define: tuple[str, ...],
    allow_path: tuple[Path, ...],
    output: Path,
    every: float | None,
) -> int:
    """Write PLAN for other programs: a map, a robotics viewer, a controller.

    Places between the steps are on the agents' own motion. MCAP needs the package `mcap`, a ROS
    bag (which is a folder) `rosbags`.
    """
    from stlc.exports import export

    check_outputs(output)
    export(*load_planned(file, plan, define, allow_path), output, every)
    return 0


@click.command("map")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path),
              help="The statements; standard output if absent.")  # fmt: skip
@click.option("--simplify", callback=metres, metavar="LENGTH",
              help="How coarse outlines may be; a cell of a grid, 1 cm of a drawing.")  # fmt: skip
@click.option("--unknown", type=click.Choice(["obstacle", "free"]), default="obstacle",
              show_default=True, help="Cells that nobody has seen.")  # fmt: skip
@click.option("--wall", callback=metres, metavar="LENGTH",
              help="Thickness of lines of a drawing that enclose nothing.")  # fmt: skip
@click.option("--unit", callback=metres, metavar="LENGTH",
              help="Of a drawing that says none, such as '1 mm'.")  # fmt: skip
@click.option("--layer", "layers", multiple=True, metavar="NAME", help="Only these of a drawing.")
@click.option("--name", help="Of the obstacles; else that of the file, or of each layer.")
def map_command(
    file: Path,
    output: Path | None,
    simplify: float | None,
    unknown: str,
    wall: float | None,
    unit: float | None,
    layers: tuple[str, ...],
    name: str | None,
) -> int:
    """Turn a map into obstacles: a grid of ROS (.yaml beside its picture) or a drawing (.dxf).

    The result is a file that a mission imports. Obstacles hold what they stand for: outlines are
    made simpler on the outside only.
    """
    from stlc.files import write_atomic
    from stlc.maps import MapOptions, read_map

    check_outputs(output)
    found = read_map(file, MapOptions(simplify, unknown == "obstacle", wall, unit, layers, name))
    for note in found.notes:
        click.echo(f"{click.style('note', bold=True)}: {note}", err=True)
    if output is None:
        click.echo(found.text, nl=False)
    else:
        write_atomic(output, found.text)
    return 0
