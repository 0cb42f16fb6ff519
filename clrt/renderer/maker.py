"""Makers: children in which programs are compiled and tried before they are trusted.

A compiler can loop until memory is full, crash, or succeed with a wrong program (see
clrt/opencl/pocl.py), and no process can catch that in itself. So a child compiles under a bound of
memory and time, tries the program (clrt/renderer/trial.py) and hands its binary back. A limit set
in this process would do with less, but where LLVM meets it, it aborts.

A child takes 0.6 s of CPU to start, so it stays for the next program, and the programs of one
picture are made by as many children as there are cores (benchmarks/NOTES.md). It ends when it has
waited for IDLE seconds, or when this process ends: its pipe is closed then.
"""

import atexit
import gc
import os
import re
import resource
import select
import signal
import struct
import subprocess
import sys
import threading
import time
import warnings
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from clrt import storage
from clrt.errors import DeviceError, LinkError
from clrt.opencl.device import devices, identity
from clrt.renderer.pack.features import Features

if TYPE_CHECKING:
    import pyopencl as cl

MEMORY = 2 << 30  # bytes; a compiler that works needs a tenth of it
SECONDS = 120  # for a program; one that works needs 1, and 20 on an emulated CPU
IDLE = 20  # seconds that a child waits for its next program
MOST = 64  # programs of one child: each adds 3 MB to it
# What clang prints where a linker fails, below the linker's own line, and where there is none.
UNLINKED = re.compile("^(.*)\nerror: linker command failed|error: (unable to execute .*)", re.M)
LINKER_HINT = "apt-get install gcc libc6-dev brings a linker"
FAILED, ELSEWHERE = 3, 4  # answers beside 0: the program is wrong; the child has another device
ANSWER = struct.Struct("<bq")  # one of them, and how many bytes follow: the binary, or the reason
LENGTH = struct.Struct("<q")  # of a job

_making = threading.Lock()
_idle: list["Maker"] = []


class Job(msgspec.Struct):
    """A program to make."""

    source: str
    features: Features
    device: tuple[str, ...]
    index: int
    """Of the device among devices()."""


class Maker:
    """A child. It makes one program at a time.

    Raises:
        OSError: there are no more processes, or no memory for one.
    """

    def __init__(self, kind: tuple[str, Path]) -> None:
        self.kind = kind
        self.fresh = True
        self.given, self.deadline = -1, 0.0
        self._said = open(os.memfd_create("said"), "rb")  # noqa: SIM115  # what it prints
        path = os.pathsep.join(filter(None, sys.path))
        try:
            self._child = subprocess.Popen(
                [kind[0], "-P", "-m", "clrt.renderer.maker"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._said,
                env={**os.environ, "PYTHONPATH": path},
            )
        except OSError:
            self._said.close()
            raise

    def fileno(self) -> int:
        """Of its answers."""
        assert self._child.stdout is not None
        return self._child.stdout.fileno()

    def waits(self) -> bool:
        """Whether it has not waited for too long."""
        return self._child.poll() is None

    def give(self, number: int, job: bytes) -> None:
        """Gives it a job, whose answer is due in SECONDS."""
        assert self._child.stdin is not None
        self.given, self.deadline = number, time.monotonic() + SECONDS
        with suppress(BrokenPipeError):  # answer() says why
            self._child.stdin.write(LENGTH.pack(len(job)) + job)
            self._child.stdin.flush()

    def answer(self) -> tuple[int, bytes] | None:
        """0 and the binary, or FAILED or ELSEWHERE and the reason; None if the child had ended
        before it saw the job.

        Raises:
            DeviceError: the child crashed.
            LinkError: its compiler found no linker that works.
        """
        assert self._child.stdout is not None
        head = self._child.stdout.read(ANSWER.size)
        if len(head) == ANSWER.size:
            status, size = ANSWER.unpack(head)
            body = self._child.stdout.read(size)
            if len(body) == size:
                self.fresh = False
                return status, body
        status = self._child.wait()
        said = os.pread(self._said.fileno(), 1 << 16, 0).decode(errors="replace").strip()
        self.kill()
        if status == 0 and not self.fresh:
            return None
        if unlinked := UNLINKED.search(said):
            raise LinkError(f"cannot link ({unlinked[1] or unlinked[2]}): {LINKER_HINT}")
        if "out of memory" in said:
            reason = f"more than {MEMORY >> 30} GB of memory"
        elif status < 0:
            reason = str(signal.strsignal(-status))
        else:
            reason = f"exit status {status}: {said.split(chr(10))[-1]}"
        raise DeviceError(f"its compiler crashed ({reason})")

    def end(self) -> None:
        """It has nothing more to do."""
        assert self._child.stdin is not None
        with suppress(BrokenPipeError):
            self._child.stdin.close()

    def kill(self) -> None:
        """Whatever it does."""
        self._child.kill()
        self.end()
        self.wait()

    def wait(self) -> None:
        """Until it has ended."""
        assert self._child.stdout is not None
        self._child.wait()
        self._child.stdout.close()
        self._said.close()


def made(
    device: "cl.Device",
    source: str,
    wanted: Sequence[Features],
    waiting: Callable[[float], object] | None = None,
) -> list[bytes]:
    """The binaries of programs that have passed their trials, in their order.

    waiting: called again and again meanwhile, with the seconds that this has taken.

    Raises:
        DeviceError: one has not. The message says why, as the end of a sentence.
    """
    found = devices()
    if device not in found or not sys.executable:  # a part of a device; Python inside a program
        return [_made_here(device, source, features) for features in wanted]
    index, name = found.index(device), identity(device)
    jobs = [msgspec.json.encode(Job(source, features, name, index)) for features in wanted]
    with _making:
        try:
            answers = _answers(jobs, waiting)
        except OSError:  # no more processes
            answers = [(ELSEWHERE, b"")] * len(jobs)
    return [
        # Elsewhere is an emulator that does not emulate what it starts.
        _made_here(device, source, features) if status == ELSEWHERE else body
        for features, (status, body) in zip(wanted, answers, strict=True)
    ]


def _made_here(device: "cl.Device", source: str, features: Features) -> bytes:
    """In this process. Only who tries a program imports the truth that it is held against."""
    from clrt.renderer import trial

    return trial.try_here(device, source, features)


def _answers(
    jobs: Sequence[bytes], waiting: Callable[[float], object] | None
) -> list[tuple[int, bytes]]:
    """By as many children at a time as this process may use cores."""
    answers: list[tuple[int, bytes]] = [(FAILED, b"")] * len(jobs)
    kind = (
        sys.executable,
        storage.cache_folder(runs=True),
    )  # where a child keeps the files of its compiler
    started, cores = time.monotonic(), len(os.sched_getaffinity(0))
    left, busy = deque(range(len(jobs))), list[Maker]()
    try:
        while left or busy:
            while left and len(busy) < cores:
                busy.append(_idle_one(kind) or Maker(kind))
                busy[-1].give(left[0], jobs[left.popleft()])
            ready, _, _ = select.select(busy, [], [], 0.1)
            for maker in ready:
                busy.remove(maker)
                answer = maker.answer()
                if answer is None:
                    left.appendleft(maker.given)
                    continue
                _idle.append(maker)
                if answer[0] == FAILED:
                    raise DeviceError(answer[1].decode(errors="replace"))
                answers[maker.given] = answer
            if any(time.monotonic() > maker.deadline for maker in busy):
                raise DeviceError(f"its compiler took more than {SECONDS} s")
            if waiting is not None:
                waiting(time.monotonic() - started)
    except BaseException:  # Ctrl-C as well
        for maker in busy:
            maker.kill()
        raise
    return answers


def _idle_one(kind: tuple[str, Path]) -> Maker | None:
    """A child that waits, of this kind; others end."""
    while _idle:
        maker = _idle.pop()
        if maker.kind == kind and maker.waits():
            return maker
        maker.kill()
    return None


@atexit.register
def _end_all() -> None:
    for maker in _idle:
        maker.end()
    for maker in _idle:  # each takes its files with it
        maker.wait()


def main() -> None:
    """The child: jobs on stdin, answers on stdout."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever a compiler prints
    for limit, most in ((resource.RLIMIT_DATA, MEMORY), (resource.RLIMIT_CORE, 0)):
        _, hard = resource.getrlimit(limit)
        resource.setrlimit(limit, (most if hard < 0 else min(most, hard), hard))
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
    jobs = sys.stdin.buffer
    for _ in range(MOST):
        if not select.select([jobs], [], [], IDLE)[0] or not (head := jobs.read(LENGTH.size)):
            return
        job = msgspec.json.decode(jobs.read(*LENGTH.unpack(head)), type=Job)
        _bound_time()
        status, body = _tried(job)
        answers.write(ANSWER.pack(status, len(body)) + body)
        answers.flush()
        gc.collect()  # OpenCL's objects, of which some refer to each other


def _bound_time() -> None:
    """For this job, should the parent be killed."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    soft = int(used.ru_utime + used.ru_stime) + SECONDS
    resource.setrlimit(resource.RLIMIT_CPU, (soft if hard < 0 else min(soft, hard), hard))


def _tried(job: Job) -> tuple[int, bytes]:
    try:
        found = devices(threads=1)
        if job.index >= len(found) or identity(found[job.index]) != job.device:
            return ELSEWHERE, b""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return 0, _made_here(found[job.index], job.source, job.features)
    except DeviceError as error:
        return FAILED, str(error).encode()


if __name__ == "__main__":
    main()
