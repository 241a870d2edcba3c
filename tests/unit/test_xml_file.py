"""The one reading of XML: what is no XML is a sentence, what stands before the root is told, nothing else is opened."""
import pytest

from cosim.master import xml_file
from cosim.master.xml_file import NotXml, prolog, root_of


@pytest.mark.parametrize("data", [
    b"", b"\0", b"<a>", b"<a/><b/>", b"words", b"\xff\xfe<", b'<?xml version="1.0" encoding="hex"?><a/>',
    b'<?xml version="1.0" encoding="rot13"?><a/>', b'<?xml version="1.0" encoding=""?><a/>', b"<a>" * 5000,
    b'<?xml version="1.0" encoding="' + b"x" * 100_000 + b'"?><a/>', b"<" + b"x" * 100_000, b"<a b='&c;'/>",
], ids=lambda data: repr(data[:40]))
def test_what_is_no_xml_is_one_sentence(data):
    with pytest.raises(NotXml) as error:
        root_of(data)
    assert str(error.value) and "\n" not in str(error.value)
    prolog(data)  # reads what it can


def test_a_document_that_is_too_large_is_not_read(monkeypatch):
    monkeypatch.setattr(xml_file, "LARGEST", 10_000_000)
    with pytest.raises(NotXml, match="it is larger than 10 MB"):
        root_of(b"<a>" + b" " * 10_000_000 + b"</a>")


@pytest.mark.parametrize("data, found", [
    (b"<a/>", xml_file.Prolog()), (b'<?xml version="1.0" encoding="latin-1"?><a/>', xml_file.Prolog("latin-1")),
    (b"<!DOCTYPE a><a/>", xml_file.Prolog(doctype=True)),
    (b'<!DOCTYPE a SYSTEM "file:///etc/passwd"><a/>', xml_file.Prolog(doctype=True, system="file:///etc/passwd")),
    (b'<!DOCTYPE a [<!ENTITY b "c"><!ENTITY d "e">]><a/>', xml_file.Prolog(doctype=True, entity="b")),
], ids=str)
def test_what_stands_before_the_root(data, found):
    assert prolog(data) == found
