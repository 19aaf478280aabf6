from benchmarks.agreement import agreement


def test_rows_of_both_ways_agree_within_the_coupling_error() -> None:
    found = agreement(["lag"], ["stop_and_go"], ["nominal", "noisy_sensors"], 1)
    assert found.rows == found.within == 4
    assert 0 < found.largest_um <= found.coupling_um < 0.2
    assert found.cells == found.same_order == found.decided_alike == 2
