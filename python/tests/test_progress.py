"""Bars of tqdm."""

from __future__ import annotations

import pytest

import tumble


def test_a_bar_is_shown_and_closed(tree, capsys):
    pytest.importorskip("tqdm")
    tumble.simulate(tree / "plans/fog_thermal_bias.toml", progress=True)
    shown = capsys.readouterr().err
    assert "%" in shown


def test_without_tqdm_the_message_says_what_to_install(tree, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    with pytest.raises(tumble.UsageError, match=r"needs the package tqdm.auto: pip install 'tumble\[progress\]'"):
        tumble.simulate(tree / "plans/fog_thermal_bias.toml", progress=True)
