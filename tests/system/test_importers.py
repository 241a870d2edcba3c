"""Our FMUs in the importers of others, in `make peers`: each flies them as we do, or fails for the reason that
docs/importers.md tells."""
import importers as matrix
import pytest

pytestmark = [pytest.mark.peers,
              pytest.mark.skipif(not all(importer.python.exists() for importer in matrix.IMPORTERS),
                                 reason="`make peers` makes the environments")]


@pytest.fixture(scope="module")
def files(native_fmus, tmp_path_factory):
    return matrix.Files(tmp_path_factory.mktemp("importers"))


@pytest.mark.parametrize("importer", matrix.IMPORTERS, ids=lambda i: f"{i.name}, {i.what}")
def test_an_importer_flies_ours_or_fails_as_told(importer, files):
    if importer.fails:
        with pytest.raises(RuntimeError) as caught:
            files.difference(importer)
        assert importer.fails in str(caught.value)
    else:
        found = files.difference(importer)
        print(f"\n{importer.name}, {importer.what}: {found:.1e}")
        assert found <= importer.limit


def test_every_importer_stands_on_the_page():
    page = matrix.PAGE.read_text()
    for importer in matrix.IMPORTERS:
        assert f"| {importer.name} | {matrix.version(importer)} | {importer.what} |" in page
