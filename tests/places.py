"""Where the checkout is, and the command line that is installed beside this Python."""
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
AHV = Path(sys.executable).with_name("ahv")
