import gzip
import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from stlc.radio import content
from stlc.radio.errors import DataError
from stlc.radio.figures import plot_summary
from stlc.radio.link_table import read_table
from stlc.radio.prior import PAPER_CHANNEL, draw_samples, main
from stlc.radio.read import SampleOptions, read_samples
from stlc.radio.report import fit_csv, format_summary

HEADER = "tx_x,tx_y,rx_x,rx_y,rssi_dbm\n"
DATA = Path(__file__).parents[2] / "examples" / "data"


def write(tmp_path, text):
    path = tmp_path / "s.csv"
    path.write_text(text)
    return path


def test_units_aliases_heights_and_receivers(tmp_path):
    text = "Robot_X [cm],robot_y_m,anchor_x_m,anchor_y_m,anchor_z_m,anchor,RSSI [dBm],split\n"
    path = write(tmp_path, text + "100,2,3,4,2.5,A,-50,calib\n200,2,3,4,2.5,B,-60,test\n")
    got = read_samples(path, SampleOptions(height=0.3, floor=-55.0))
    np.testing.assert_allclose(got.links[0], [1.0, 2.0, 0.3, 3.0, 4.0, 2.5])
    assert got.names == ("A", "B")
    assert got.censored.tolist() == [False, True]
    only = read_samples(path, SampleOptions(where=("split", "test")))
    assert only.rssi.tolist() == [-60.0]


def test_gzip_is_read(tmp_path):
    path = tmp_path / "s.csv.gz"
    path.write_bytes(gzip.compress((HEADER + "0,0,1,1,-40\n").encode()))
    assert read_samples(path).rssi.tolist() == [-40.0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the file is empty"),
        (HEADER, "no samples"),
        ("tx_x,tx_y,rx_x,rssi\n1,2,3,4\n", r":1: no column for rx_y"),
        (HEADER + "0,0,1,1,-40\n0,0,1,x,-40\n", r":3:4: 'x' is not a number"),
        (HEADER + "0,0,1,1,nan\n", r":2:5: 'nan' is not a finite number"),
        (HEADER + "0,0,1,1\n", r":2: 4 values where the header has 5"),
        ("tx_x,x1,tx_y,rx_x,rx_y,rssi\n", r":1:2: columns 1 and 2 both give tx_x"),
        ("tx_x [ft],tx_y,rx_x,rx_y,rssi\n", r":1:1: unit 'ft' does not fit tx_x"),
    ],
)
def test_bad_sample_files_are_located(tmp_path, text, message):
    with pytest.raises(DataError, match=message):
        read_samples(write(tmp_path, text))


def test_missing_and_binary_files(tmp_path):
    with pytest.raises(DataError, match="no such file"):
        read_samples(tmp_path / "none.csv")
    path = tmp_path / "b.csv"
    path.write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(DataError, match="not a text file"):
        read_samples(path)


def test_tables_from_csv_and_npz(tmp_path):
    values = np.arange(6.0).reshape(2, 3)
    path = tmp_path / "t.csv"
    np.savetxt(path, values, delimiter=",")
    np.testing.assert_array_equal(read_table(path), values)
    np.savez(tmp_path / "t.npz", cost=values)
    np.testing.assert_array_equal(read_table(tmp_path / "t.npz"), values)
    np.savez(tmp_path / "two.npz", a=values, b=2 * values)
    with pytest.raises(DataError, match="2 arrays"):
        read_table(tmp_path / "two.npz")
    np.testing.assert_array_equal(read_table(tmp_path / "two.npz", "b"), 2 * values)
    path.write_text("1,2\n3\n")
    with pytest.raises(DataError, match=r":2: 1 values where the first line has 2"):
        read_table(path)


def test_pickled_and_broken_archives_are_refused(tmp_path):
    np.savez(tmp_path / "p.npz", a=np.array([{"x": 1}], dtype=object))
    with pytest.raises(DataError, match="never read"):
        read_table(tmp_path / "p.npz")
    (tmp_path / "q.npz").write_bytes(b"not an archive")
    with pytest.raises(DataError, match="cannot read"):
        read_table(tmp_path / "q.npz")


def test_shipped_samples_are_what_the_module_writes(tmp_path):
    path = tmp_path / "again.csv"
    assert main(["-o", str(path), "--count", "80", "--seed", "1"]) == 0
    ours, shipped = read_samples(path), read_samples(DATA / "paper_samples.csv")
    np.testing.assert_array_equal(ours.links, shipped.links)
    # the draw goes through a Cholesky factor, whose last bits may differ between machines
    np.testing.assert_allclose(ours.rssi, shipped.rssi, atol=0.0011)
    assert list(tmp_path.iterdir()) == [path]


def test_report_prints_and_draws(tmp_path):
    path = tmp_path / "s.csv"
    main(["-o", str(path), "--count", "60", "--seed", "4"])
    summary = fit_csv(path)
    text = format_summary(summary)
    for word in ("L0", "shadowing", "path loss alone", "held back", "exact likelihood"):
        assert word in text
    plot_summary(summary, tmp_path / "fit.png")
    assert (tmp_path / "fit.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_draws_depend_on_the_seed_alone():
    one, two = (draw_samples(PAPER_CHANNEL, -5, 5, 10, 2) for _ in range(2))
    np.testing.assert_array_equal(one.rssi, two.rssi)


def _archive(path, data):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.npy", data)


def test_an_archive_that_claims_more_than_it_holds(tmp_path):
    """Terabytes by its header: refused before any memory is asked for."""
    stream = io.BytesIO()
    claim = {"descr": "<f8", "fortran_order": False, "shape": (1_000_000, 1_000_000)}
    np.lib.format.write_array_header_1_0(stream, claim)
    _archive(tmp_path / "claims.npz", stream.getvalue() + bytes(80))
    with pytest.raises(DataError, match="claims 8000000000000 bytes, the file holds 80"):
        read_table(tmp_path / "claims.npz")


def test_what_unpacks_without_end(tmp_path, monkeypatch):
    monkeypatch.setattr(content, "MOST_BYTES", 2**20)
    _archive(tmp_path / "bomb.npz", bytes(2**22))
    with pytest.raises(DataError, match="unpacks to more than 1 MiB"):
        read_table(tmp_path / "bomb.npz")
    (tmp_path / "bomb.csv.gz").write_bytes(gzip.compress(bytes(2**22)))
    with pytest.raises(DataError, match="unpacks to more than 1 MiB"):
        read_samples(tmp_path / "bomb.csv.gz")


def test_files_under_the_wrong_name(tmp_path):
    np.save(tmp_path / "a.npy", np.ones((2, 2)))
    np.savez(tmp_path / "b.npz", np.ones((2, 2)))
    (tmp_path / "one.npz").write_bytes((tmp_path / "a.npy").read_bytes())
    with pytest.raises(DataError, match="one array"):
        read_table(tmp_path / "one.npz")
    for source, name in (("a.npy", "c.csv"), ("b.npz", "d.csv"), ("a.npy", "a.npy")):
        (tmp_path / name).write_bytes((tmp_path / source).read_bytes())
        with pytest.raises(DataError, match="not a"):
            read_table(tmp_path / name)
    (tmp_path / "text.npz").write_text("1,2\n3,4\n")
    with pytest.raises(DataError, match="cannot read"):
        read_table(tmp_path / "text.npz")


def test_cells_beyond_all_measure(tmp_path):
    (tmp_path / "a.csv").write_text("1,2\n" + "9" * 200_000 + ",4\n")
    with pytest.raises(DataError, match=r"a\.csv:2: not a CSV file: field larger"):
        read_table(tmp_path / "a.csv")
    (tmp_path / "b.csv").write_text("1,2\n3,\0\n")
    with pytest.raises(DataError, match=r"b\.csv:2"):
        read_table(tmp_path / "b.csv")
