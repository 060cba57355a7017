"""Sample files as people write them: separators, comments, units, and strengths that are none."""

import numpy as np
import pytest

from stlc.radio.errors import DataError, FitError
from stlc.radio.fit import FitOptions, fit_channel
from stlc.radio.link_table import read_table
from stlc.radio.read import SampleOptions, read_samples
from stlc.radio.samples import make_samples

HEADER = "tx_x,tx_y,rx_x,rx_y,rssi_dbm\n"
LINKS = [[0.0, 0.5, 1.0, 2.0], [3.0, 4.0, 5.0, 6.25]]


def write(tmp_path, text, encoding="utf-8"):
    path = tmp_path / "s.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize(
    "text",
    [
        HEADER + "0,.5,1,2,-40\n3,4,5,6.25,-50.5\n",
        HEADER.replace(",", ";") + "0;0,5;1;2;-40\n3;4;5;6,25;-50,5\n",
        HEADER.replace(",", ";") + "0;0.5;1;2;-40\r\n3;4;5;6.25;-50.5\r\n",
        HEADER.replace(",", "\t") + "0\t0,5\t1\t2\t-40\n3\t4\t5\t6.25\t-50,5\n",
        HEADER.replace(",", "  ") + "0 0.5 1   2 -40\n 3 4 5 6.25 -50.5\n",
        "# a campaign\n\n" + HEADER + "# first\n0,.5,1,2,-40\n\n,,,,\n3,4,5,6.25,-50.5\n# end",
        "# " + HEADER + "0,.5,1,2,-40\n3,4,5,6.25,-50.5\n",
        "TX X [cm];x_tx_ignored;Tx Y [cm];x_rx (m);y2_m;RSSI [dBm]\n"
        "0;;50;1;2;-40\n300;;400;5;6,25;-50,5\n",
        HEADER + "m,m,m,m,dBm\n0,.5,1,2,-40\n3,4,5,6.25,-50.5\n",
        HEADER + "[mm],(mm),m,m,\n0,500,1,2,-40\n3000,4000,5,6.25,-50.5\n",
        "\ufeff" + HEADER + '"0",".5","1","2","-40"\n3,4,5,6.25,\N{MINUS SIGN}50.5\n',
        "sender_x,sender_y,x_receiver,y_receiver,signal strength\n0,.5,1,2,-40\n3,4,5,6.25,-50.5\n",
    ],
)
def test_files_as_people_write_them(tmp_path, text):
    got = read_samples(write(tmp_path, text))
    np.testing.assert_allclose(got.links, LINKS)
    np.testing.assert_allclose(got.rssi, [-40.0, -50.5])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1,2,3,4,-40\n1,2,3,5,-40\n", r":1: the first line holds numbers: there is no header"),
        ("lat,lon,rx_x,rx_y,rssi\n", r"no column for tx_x, tx_y \(turn degrees into metres"),
        ("tx_x,tx_y,rx_x,rx_y,loud\n", r"no column for rssi .*it has tx_x, tx_y, rx_x, rx_y, loud"),
        (HEADER + "0,5,1,2,3,-40,5\n", r":2: 7 values where the header has 5 .*part the columns"),
        ("# x\n\n" + HEADER + "# y\n0,0,1,x,-40\n", r":5:4: 'x' is not a number"),
        (HEADER.replace(",", ";") + "0;0;1;1.234,5;-40\n", r":2:4: '1.234,5' is not a number"),
        (HEADER + "furlong,m,m,m,dBm\n0,0,1,1,-40\n", r":2:1: 'furlong' is not a number"),
        (HEADER + "s,m,m,m,dBm\n0,0,1,1,-40\n", r":1:1: unit 's' does not fit tx_x"),
        (HEADER + '0,0,1,"1,-40\n', r":2: 4 values"),
    ],
)
def test_what_cannot_be_read_is_located(tmp_path, text, message):
    with pytest.raises(DataError, match=message):
        read_samples(write(tmp_path, text))


@pytest.mark.parametrize(
    ("cell", "message"),
    [
        ("0", "0 dBm is more than a receiver measures"),
        ("100", "100 dBm is more than a receiver measures"),
        ("127", "127 dBm is more than a receiver measures"),
        ("255", "255 dBm is more than a receiver measures"),
        ("3.5", "3.5 dBm is more than a receiver measures"),
        ("-200", "-200 dBm is below thermal noise"),
        ("-999", "-999 dBm is below thermal noise"),
        ("NaN", "'NaN' is not a finite number"),
        ("inf", "'inf' is not a finite number"),
        ("", "no strength is given"),
        ("n/a", "'n/a' is not a number"),
    ],
)
def test_strengths_that_are_none_name_row_and_remedy(tmp_path, cell, message):
    path = write(tmp_path, f"{HEADER}0,0,1,1,-40\n0,0,2,2,{cell}\n0,0,3,3,-50\n0,0,4,4,{cell}\n")
    with pytest.raises(DataError) as caught:
        read_samples(path)
    assert f":3:5: {message} (and 1 more such row)" in str(caught.value)
    assert "not_heard" in caught.value.help
    declared = read_samples(path, SampleOptions(floor=-90.0, not_heard=(cell,)))
    np.testing.assert_array_equal(declared.rssi, [-40.0, -90.0, -50.0, -90.0])
    assert declared.censored.tolist() == [False, True, False, True]


def test_marks_are_numbers_or_texts_and_need_a_floor(tmp_path):
    path = write(tmp_path, HEADER + "0,0,1,1,127.0\n0,0,2,2,-\n0,0,3,3,-50\n")
    got = read_samples(path, SampleOptions(floor=-90.0, not_heard=("127", "-")))
    assert got.censored.tolist() == [True, True, False]
    with pytest.raises(DataError, match="needs a floor"):
        read_samples(path, SampleOptions(not_heard=("127", "-")))


def test_marks_below_the_floor_are_censored_as_they_are(tmp_path):
    path = write(tmp_path, HEADER + "0,0,1,1,-200\n0,0,3,3,-50\n")
    assert read_samples(path, SampleOptions(floor=-90.0)).censored.tolist() == [True, False]


def test_relative_strengths_may_be_positive(tmp_path):
    text = HEADER.replace("rssi_dbm", "rss_db") + "0,0,1,1,12\n0,0,1,2,-4\n"
    assert read_samples(write(tmp_path, text)).rssi.tolist() == [12.0, -4.0]
    with pytest.raises(DataError, match="-999 dB is no difference"):
        read_samples(write(tmp_path, text + "0,0,1,2,-999\n"))


def test_links_that_are_all_within_d0_are_refused():
    rng = np.random.default_rng(0)
    samples = make_samples(rng.uniform(0, 0.5, (30, 4)), rng.normal(-40, 3, 30))
    with pytest.raises(FitError, match=r"no link is longer than d0 = 1 m.*smaller d0"):
        fit_channel(samples)
    assert fit_channel(samples, FitOptions(d0=0.01)).links == 30


def test_tables_have_the_same_separators(tmp_path):
    path = write(tmp_path, "# cost\n1;2,5\n3;4\n")
    np.testing.assert_array_equal(read_table(path), [[1.0, 2.5], [3.0, 4.0]])
