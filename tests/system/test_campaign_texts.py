"""Texts of strangers in a campaign's report: names of systems, units, descriptions, messages, words that are drawn."""
import pytest
from campaign_pages import made_up, page_of
from test_pages import ATTACKS, Seen


def seen(folder, text):
    return Seen(page_of(made_up(folder, text, 12)))


@pytest.fixture(scope="module")
def harmless(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cosim.pages.write.library", lambda: "'use strict'")  # a parser takes a second for BokehJS
        yield seen(tmp_path_factory.mktemp("harmless"), "x")


@pytest.mark.parametrize("attack", ATTACKS, ids=range(len(ATTACKS)))
def test_texts_of_strangers_stay_texts(attack, tmp_path, harmless):
    found = seen(tmp_path, attack)
    assert found.tags == harmless.tags
    assert [name for name, _ in found.attributes] == [name for name, _ in harmless.attributes]
    assert found.scripts[1:] == harmless.scripts[1:]  # all but the data
