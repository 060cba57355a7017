import gzip
import json
from unittest import mock

import numpy as np
import pytest

from stlc.cli.common import run_guarded
from stlc.cli.fit import fit_command
from stlc.radio.prior import PAPER_CHANNEL, draw_samples

HEADER = "tx_x,tx_y,rx_x,rx_y,rssi_dbm"
NUMBERS = np.random.default_rng(0).uniform(0, 9, (40, 4))


def lines(links, strengths):
    rows = [",".join(f"{v:.4f}" for v in (*y, r)) for y, r in zip(links, strengths, strict=True)]
    return "\n".join([HEADER, *rows]) + "\n"


def run(capsys, *arguments):
    with mock.patch("sys.argv", ["stlc", *map(str, arguments)]):
        status = run_guarded(fit_command)
    out, err = capsys.readouterr()
    return status, out, err


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    drawn = draw_samples(PAPER_CHANNEL, -5, 5, 60, 3)
    path = tmp_path_factory.mktemp("fit") / "good.csv.gz"
    path.write_bytes(gzip.compress(lines(drawn.links, drawn.rssi).encode()))
    return path


def test_json_holds_the_channel_and_how_it_forecasts(capsys, good):
    status, out, _ = run(capsys, good, "--json")
    found = json.loads(out)
    assert status == 0
    assert found["samples"] == 60
    assert found["channel"]["shadowing"] > 0
    assert found["held_back"]["samples"] == 12
    assert set(found["held_back"]["channel"]["coverage"]) == {"0.5", "0.9", "0.95"}
    assert found["approximation"] == {}


def test_text_and_picture(capsys, good, tmp_path):
    picture = tmp_path / "fit.png"
    status, out, _ = run(capsys, good, "-o", picture)
    assert status == 0
    assert "held back     12 samples" in out
    assert picture.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_rows_are_chosen_and_heights_filled_in(capsys, tmp_path):
    text = lines(NUMBERS, -40.0 - NUMBERS[:, 0]).splitlines()
    labelled = [text[0] + ",rx_z,kind"] + [
        f"{row},2.5,{'a' if k % 2 else 'b'}" for k, row in enumerate(text[1:])
    ]
    path = tmp_path / "s.csv"
    path.write_text("\n".join(labelled))
    status, out, _ = run(capsys, path, "--where", "kind=a", "--height", "0.5", "--json")
    assert (status, json.loads(out)["samples"]) == (0, 20)
    status, _, err = run(capsys, path, "--where", "sort=a")
    assert status == 1
    assert "no column 'sort'" in err


SAME = np.tile([0.0, 0.0, 1.0, 1.0], (30, 1))
SPACED = np.column_stack([np.arange(30.0), np.zeros(30), np.arange(30.0) + 1, np.zeros(30)])
TWO = np.column_stack([np.zeros((30, 2)), 1.0 + np.arange(30) % 2, np.zeros(30)])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "s.csv: the file is empty"),
        (HEADER + "\n", "no samples"),
        ("tx_x,tx_y,rx_x,rssi\n1,2,3,4\n", "s.csv:1: no column for rx_y"),
        (HEADER + "\n0,0,1,1,-40\n0,0,1,nan,-40\n", "s.csv:3:4: 'nan' is not a finite number"),
        (HEADER + "\n0,0,1,1,loud\n", "s.csv:2:5: 'loud' is not a number"),
        (HEADER + "\n0,0,1,1,1e300\n", "s.csv:2:5: '1e300' is out of range"),
        (HEADER + "\n0,0,1,1,-40\n", "1 samples are too few"),
        (lines(SAME, -40.0 - np.arange(30) % 3), "the same length"),
        (lines(SPACED, -40.0 - np.arange(30) % 3), "the same length"),
        (lines(NUMBERS, np.full(40, -40.0)), "the same strength"),
        (lines(TWO, -40.0 - np.arange(30) % 3), "held back, all links have the same length"),
        (lines(NUMBERS[:9], -40.0 - np.arange(9)), "held back, 7 samples are too few"),
    ],
)
def test_odd_files_are_explained(capsys, tmp_path, text, message):
    path = tmp_path / "s.csv"
    path.write_text(text)
    status, out, err = run(capsys, path)
    assert (status, out) == (1, "")
    assert message in err


@pytest.mark.parametrize(
    "arguments",
    [["--share", "1"], ["--d0", "0"], ["--seed", "-1"], ["--where", "kind"], ["--sharp"]],
)
def test_wrong_usage_is_status_2(capsys, good, arguments):
    status, _, err = run(capsys, good, *arguments)
    assert status == 2
    assert arguments[0] in err


def test_files_that_are_not_there(capsys, good, tmp_path):
    assert run(capsys, tmp_path / "none.csv")[0] == 2
    assert run(capsys, tmp_path)[0] == 2
    assert run(capsys, good, "--test", tmp_path)[0] == 2
    assert run(capsys, good, "--test", tmp_path / "none.csv")[0] == 2
    assert run(capsys, good, "-o", tmp_path / "none" / "fit.png")[0] == 74
    (tmp_path / "torn.gz").write_bytes(b"\x1f\x8bxxxx")
    status, _, err = run(capsys, tmp_path / "torn.gz")
    assert status == 1
    assert "torn.gz: cannot unpack the file" in err
