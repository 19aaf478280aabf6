"""Of what an FMU logs, a failure is told what explains it."""

from warmlink.orchestration.master.slaves.fmu_log import FmuLog

OK, WARNING, ERROR = 0, 1, 3


def test_information_is_no_complaint_but_better_than_silence() -> None:
    log = FmuLog()
    assert (log.complains, log.tell()) == (False, "; it logged nothing")
    for number in range(5):
        log.add(OK, f"line {number}")
    assert (log.complains, log.tell()) == (False, "; it logged: line 2 | line 3 | line 4")


def test_the_last_five_complaints_are_told_each_once() -> None:
    log = FmuLog()
    for text in ("a", "b", "c", "d", "d", "e"):
        log.add(WARNING, text)
    log.add(OK, "all is well")
    assert (log.complains, log.tell()) == (True, "; it logged: b | c | d | e")


def test_bytes_in_any_encoding_and_on_several_lines_become_one_line() -> None:
    log = FmuLog()
    log.add(ERROR, b"too \xff hot\n  at  T")
    assert log.tell() == "; it logged: too \ufffd hot at T"
    log.add(ERROR, None)
    assert log.tell() == "; it logged: too \ufffd hot at T"


def test_a_status_that_fmi_does_not_know_is_kept_by_its_number() -> None:
    log = FmuLog()
    log.add(17, "strange")
    log.add(-1, "stranger")
    assert [*log.lines] == [("17", "strange"), ("-1", "stranger")]
    assert log.complains


def test_only_the_last_lines_are_kept_and_a_log_goes_with_its_instance() -> None:
    log = FmuLog()
    for number in range(300):
        log.add(OK, str(number))
    assert (len(log.lines), log.lines[0]) == (200, ("ok", "100"))
    key = log.key
    assert FmuLog.open[key] is log
    del log  # nothing refers to it in a circle
    assert key not in FmuLog.open
