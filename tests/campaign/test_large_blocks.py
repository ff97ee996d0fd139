"""Memory that is free goes back to the system, also where small blocks lie among large ones."""

import subprocess
import sys

import pytest

FREED = """
import numpy as np
from refdem.campaign.large_blocks import give_back_large_blocks

def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096

give_back_large_blocks()
# By itself glibc puts blocks of up to this size on its heap from now on.
np.ones(7 * 2**19)
before = resident()
large, small = [], []
for _ in range(4):
    large.append(np.ones(3 * 2**20))
    small.append(np.ones(2**12))
large.clear()
print(resident() - before)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the resident memory is read from /proc")
def test_large_blocks_go_back_to_the_system_from_among_small_ones() -> None:
    command = [sys.executable, "-c", FREED]
    held = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    assert int(held.stdout) < 8 * 2**20
