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


@pytest.fixture(scope="module")
def files3(native_fmi3_fmus, tmp_path_factory):
    return matrix.Files(tmp_path_factory.mktemp("importers3"), "native-fmi3")


@pytest.mark.parametrize("importer", [i for i in matrix.IMPORTERS if i.what in (matrix.LOOP, matrix.CONTROLLER)],
                         ids=lambda i: f"{i.name}, {i.what}")
def test_an_importer_flies_ours_of_fmi_3_or_fails_as_told(importer, files3):
    if importer.fails3:
        with pytest.raises(RuntimeError, match=importer.fails3):
            files3.difference(importer)
    else:
        assert files3.difference(importer) <= importer.limit


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
