"""Devices: found by any part of their label."""

import os
import subprocess
import sys
from pathlib import Path

import pyopencl as cl
import pytest

from clrt.errors import DeviceError
from clrt.opencl.device import devices, find_device, label


def test_the_first_is_the_default() -> None:
    assert find_device() == devices()[0]


def test_found_by_its_label(device: cl.Device) -> None:
    assert find_device(label(device)) == device
    assert find_device(label(device).upper()) == device
    assert find_device(device.driver_version) == device


def test_threads_cannot_change_any_more() -> None:
    cores = find_device("Portable").max_compute_units
    assert find_device("Portable", threads=cores)
    with pytest.raises(DeviceError, match=f"runs with {cores} threads, not {cores + 1}"):
        find_device("Portable", threads=cores + 1)


def test_pips_pocl_comes_before_the_systems() -> None:
    """In a process where both are seen."""
    code = (
        "from clrt.opencl import device, pocl\n"
        "for found in filter(device.is_pocl, device.devices()): print(pocl.library(found))"
    )
    environment = {name: value for name, value in os.environ.items() if name != "OCL_ICD_VENDORS"}
    said = subprocess.check_output([sys.executable, "-c", code], env=environment, text=True)
    first, *others = map(Path, said.split())
    if not others:
        pytest.skip("apt-get install pocl-opencl-icd")
    assert "site-packages" in first.parts
    assert all("site-packages" not in other.parts for other in others)
