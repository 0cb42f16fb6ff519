"""clrt devices: the OpenCL devices, and the facts that a bug report needs."""

import os

import click

from clrt import cgroups


@click.command()
@click.option("-v", "--verbose", is_flag=True, help="Say what a bug report needs.")
def devices(verbose: bool) -> None:
    """Lists the OpenCL devices; the first is the default."""
    from clrt.opencl import pocl
    from clrt.opencl.device import devices as found
    from clrt.opencl.device import label

    for device in found():
        click.echo(label(device))
        if verbose:
            click.echo(
                f"  platform  {device.platform.version.strip()}\n"
                f"  device    {device.version.strip()}\n"
                f"  CPU       {pocl.name_given(device) or 'as PoCL says'}\n"
                f"  threads   {device.max_compute_units}\n"
                f"  lanes     {device.native_vector_width_float} of float32, "
                f"{device.native_vector_width_double} of float64\n"
                f"  memory    {device.global_mem_size >> 20} MB"
            )
    if verbose:
        import platform
        from importlib.metadata import version

        from clrt.storage import cache_folder

        packages = ("clrt", "pyopencl", "numpy", "pillow", "msgspec", "click")
        click.echo(
            f"cache       {cache_folder()}\n"
            f"versions    {', '.join(f'{name} {version(name)}' for name in packages)}, "
            f"Python {platform.python_version()}\n"
            f"machine     {platform.platform()}, {cgroups.cores()} of "
            f"{os.cpu_count()} cores"
        )
