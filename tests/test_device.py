"""Devices: found by any part of their label."""

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
