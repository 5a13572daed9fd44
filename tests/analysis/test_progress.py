"""Progress: shown to whoever waits at a terminal or in a notebook, and to nobody else."""

import io
import multiprocessing
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

import blockstruct as bs


class Terminal(io.StringIO):
    def isatty(self):
        return True


def on_terminal(monkeypatch):
    """Make standard output and standard error a terminal, whose text is returned."""
    screen = Terminal()
    monkeypatch.setattr(sys, "stdout", screen)
    monkeypatch.setattr(sys, "stderr", screen)
    return screen


def test_a_terminal_shows_which_case_is_run(small_model, small_cases, monkeypatch):
    terminal = on_terminal(monkeypatch)
    bs.run(small_model, small_cases)
    shown = terminal.getvalue().split("\r")
    assert shown[1].startswith("case 1 of 2, push associative: 8 blocks")
    assert any(line.startswith("case 2 of 2, push nonassociative: numerical iteration 3, ") for line in shown)
    # What is over leaves an empty line behind.
    assert shown[-2].strip() == shown[-1] == ""


@pytest.mark.parametrize("given", [{"progress": False}, {"listeners": [lambda event: None]}])
def test_nothing_is_shown_where_it_is_not_wanted(small_model, small_cases, monkeypatch, given):
    terminal = on_terminal(monkeypatch)
    bs.run(small_model, small_cases[:1], **given)
    assert terminal.getvalue() == ""


def test_progress_that_is_asked_for_comes_beside_listeners_and_without_a_terminal(small_model, small_cases, capsys):
    events = []
    bs.run(small_model, small_cases[:1], listeners=[events.append], progress=True)
    assert events
    assert "push associative: 8 blocks" in capsys.readouterr().err


def test_workers_are_silent(small_model, small_cases, monkeypatch):
    terminal = on_terminal(monkeypatch)
    with ThreadPoolExecutor(1) as pool:
        pool.submit(bs.run, small_model, small_cases[:1]).result()
    monkeypatch.setattr("blockstruct.notebook.parent_process", multiprocessing.current_process)
    bs.run(small_model, small_cases[:1])
    assert terminal.getvalue() == ""


@pytest.mark.parametrize("stream", [None, object()])
def test_a_stream_that_is_none_is_not_a_terminal(small_model, small_cases, monkeypatch, stream):
    monkeypatch.setattr(sys, "stdout", stream)
    assert bs.run(small_model, small_cases[:1]).status == "finished"


def test_a_notebook_has_one_output_that_is_replaced(small_model, small_cases, monkeypatch):
    shown = []

    class Handle:
        def update(self, content, *, raw):
            shown[-1] = content["text/plain"]

    class Kernel:
        kernel = object()

    class IPython:
        get_ipython = Kernel

        class display:  # noqa: N801 - the name of the module
            @staticmethod
            def display(content, *, raw, display_id):
                shown.append(content["text/plain"])
                return Handle()

    monkeypatch.setitem(sys.modules, "IPython", IPython)
    analysis = bs.run(small_model, small_cases)
    count = analysis["push nonassociative"].n_iterations
    assert shown == [f"case 2 of 2, push nonassociative: converged after {count} numerical iterations"]


def test_other_words_are_refused(small_model):
    with pytest.raises(bs.errors.ModelError, match="progress is 'always'; give True, False or 'auto'"):
        bs.AnalysisManager(small_model, progress="always")
