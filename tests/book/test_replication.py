"""The one command that replicates: it holds on any processor, and fails for another number."""

from cmtof_book import replication
from cmtof_book.compared import closed_form, decision


def test_it_replicates_and_draws(run, tmp_path):
    code, text, err = run("replicate -o fig10.png")
    assert code == 0, text + err
    assert text.count("PASS") == 10
    assert (tmp_path / "fig10.png").read_bytes().startswith(b"\x89PNG")


def test_a_number_out_of_its_tolerance_fails_the_command(run, monkeypatch):
    outcomes = [
        replication.Outcome("a quantity", 2.0, closed_form(1.0)),
        replication.Outcome("a share", 0.2, decision(0.9, at_least=0.5)),
        replication.Outcome("not a number", float("nan"), closed_form(1.0)),
    ]
    monkeypatch.setattr(replication, "replicate", lambda figure: iter(outcomes))
    code, text, err = run("replicate -o f.png")
    assert code == 1
    assert text.count("FAIL") == 3
    assert "got 3 FAIL" in err
