"""The one command that replicates: it holds on any processor, and fails for another number."""

import numpy as np
from pytest import mark

from cmtof_book import replication
from cmtof_book.compared import closed_form, decision


def test_it_replicates_and_draws(run, tmp_path):
    code, text, err = run("replicate", "-o", tmp_path / "fig10.png")
    assert code == 0, text + err
    assert text.count("PASS") == 10
    assert (tmp_path / "fig10.png").read_bytes().startswith(b"\x89PNG")


def test_a_number_out_of_its_tolerance_fails_the_command(run, tmp_path, monkeypatch):
    outcomes = [
        replication.Outcome("a quantity", 2.0, closed_form(1.0)),
        replication.Outcome("a share", 0.2, decision(0.9, at_least=0.5)),
        replication.Outcome("not a number", float("nan"), closed_form(1.0)),
    ]
    monkeypatch.setattr(replication, "replicate", lambda figure: iter(outcomes))
    code, text, err = run("replicate", "-o", tmp_path / "f.png")
    assert code == 1
    assert text.count("FAIL") == 3
    assert "got 3 FAIL" in err


@mark.parametrize("kind", ["sum over draws", "decision"])
def test_values_at_several_seeds_give_mean_and_spread(kind):
    seeds = [0.6, 0.7, 0.8]  # mean 0.7, standard deviation 0.1, of which five are 0.5
    held = replication.expected({"kind": kind, "what": "a share", "seeds": seeds})
    assert np.isclose(held.value, 0.7)
    assert held.accepts(0.21)
    assert not held.accepts(0.19)
    assert held.accepts(1.21) is (kind == "decision")
