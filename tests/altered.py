"""FMU files with another modelDescription.xml."""
import io
import zipfile
from pathlib import Path


def redescribed(fmu: Path | bytes, target: Path, *swaps: tuple[str, str], member: str = "modelDescription.xml") -> Path:
    """A copy of an FMU at `target`, with the first text of each pair, which must be there, replaced by the second, in
    `member`."""
    source = io.BytesIO(fmu) if isinstance(fmu, bytes) else fmu
    with zipfile.ZipFile(source) as before, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as after:
        for name in before.namelist():
            content = before.read(name)
            if name == member:
                for old, new in swaps:
                    assert old.encode() in content, old
                    content = content.replace(old.encode(), new.encode())
            after.writestr(name, content)
    return target
