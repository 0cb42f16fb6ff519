"""The linker: objects made here by hand, each loaded and run, and pictures equal to GNU ld's."""

import ctypes
import os
import shutil
import struct
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

import clrt
from clrt.opencl import linker, pocl, program
from clrt.renderer import maker, trial

ALLOC, WRITE, RUN, TLS = 2, 1, 4, 0x400
PROGBITS, NOBITS, INIT_ARRAY = 1, 8, 14
# Sections of every object here, by their numbers: what is run, read, written, and zero.
TEXT, RODATA, DATA, BSS = 1, 2, 3, 4
# Symbols: what is local to the object, what it hands on, and what it needs.
LOCAL, GLOBAL, WEAK = 0, 1 << 4, 2 << 4
ABSOLUTE, COMMON = 0xFFF1, 0xFFF2


def made(
    text: bytes = b"",
    symbols: Sequence[tuple[bytes, int, int, int]] = (),
    relocations: Sequence[tuple[int, int, int, int, int]] = (),
    rodata: bytes = b"",
    data: bytes = b"",
    zeros: int = 0,
    section: tuple[int, int] | None = None,
    machine: int = 62,
) -> bytes:
    """An object.

    Args:
        symbols: name, binding (with its kind), section, value.
        relocations: section, offset, kind, symbol (from 1), addend.
        section: kind and flags of one more.
    """
    sections = [
        (b".text", PROGBITS, ALLOC | RUN, text, 16, 0, 0),
        (b".rodata", PROGBITS, ALLOC, rodata, 64, 0, 0),
        (b".data", PROGBITS, ALLOC | WRITE, data, 8, 0, 0),
        (b".bss", NOBITS, ALLOC | WRITE, bytes(zeros), 8, 0, 0),
        (b".comment", PROGBITS, 0, b"by hand", 1, 0, 0),
        (b".eh_frame", PROGBITS, ALLOC, bytes(8), 8, 0, 0),
    ]
    names, table = b"\0", bytes(24)
    for name, binding, index, value in symbols:
        table += struct.pack("<I2BH2Q", len(names), binding, 0, index, value, 0)
        names += name + b"\0"
    string_table = len(sections) + 1
    sections.append((b".strtab", 3, 0, names, 1, 0, 0))
    symbol_table = len(sections) + 1
    sections.append((b".symtab", 2, 0, table, 8, string_table, 0))
    packed: dict[int, bytes] = {6: struct.pack("<2Qq", 0, 1 << 32 | 2, 0)}  # of .eh_frame
    for index, offset, kind, symbol, addend in relocations:
        words = struct.pack("<2Qq", offset, symbol << 32 | kind, addend)
        packed[index] = packed.get(index, b"") + words
    for index, words in packed.items():
        sections.append((b".rela", 4, 0, words, 8, symbol_table, index))
    if section is not None:
        sections.append((b".more", section[0], section[1], bytes(8), 8, 0, 0))
    words = b"".join(name + b"\0" for name, *_ in sections) + b".shstrtab\0"
    sections.append((b".shstrtab", 3, 0, words, 1, 0, 0))
    body, headers, at = b"", bytes(64), 0
    for name, kind, flags, content, align, link, info in sections:
        body += bytes(-len(body) % align)
        place = 64 + len(body)
        headers += struct.pack(
            "<2I4Q2I2Q", at, kind, flags, 0, place, len(content), link, info, align, 0
        )
        body += b"" if kind == NOBITS else content
        at += len(name) + 1
    head = (b"\x7fELF\x02\x01\x01", 1, machine, 1, 0, 0, 64 + len(body), 0, 64, 0, 0, 64)
    count = len(sections) + 1
    return struct.pack("<16s2HI3QI6H", *head, count, count - 1) + body + headers


def loaded(tmp_path: Path, content: bytes) -> ctypes.CDLL:
    path = tmp_path / "made.so"
    path.write_bytes(linker.linked(content))
    return ctypes.CDLL(str(path))


RIP = bytes(4)
F = (b"f", GLOBAL, TEXT, 0)
MEMCPY = (b"memcpy", GLOBAL, 0, 0)
WORD = struct.pack("<q", 1234567)


def copies(function: Any) -> bool:
    """Whether it is memcpy()."""
    target = ctypes.create_string_buffer(5)
    function(target, b"word", 4)
    return target.value == b"word"


def returns(function: Any) -> bool:
    return bool(function() == 1234567)


def points(function: Any) -> bool:
    """Whether it returns where the word is."""
    function.restype = ctypes.c_void_p
    return ctypes.c_int64.from_address(function()).value == 1234567


KNOWN: dict[str, tuple[Callable[[Any], bool], dict[str, Any]]] = {
    # mov eax, [rip + word]; ret
    "PC32": (returns, {
        "text": b"\x8b\x05" + RIP + b"\xc3", "rodata": bytes(64) + WORD,
        "symbols": [F, (b"", LOCAL | 3, RODATA, 0)], "relocations": [(TEXT, 2, 2, 2, 60)],
    }),
    # jmp g; nop; g: mov eax, 1234567; ret
    "PLT32": (returns, {
        "text": b"\xe9" + RIP + b"\x90\xb8" + WORD[:4] + b"\xc3",
        "symbols": [F, (b"g", LOCAL, TEXT, 6)], "relocations": [(TEXT, 1, 4, 2, -4)],
    }),
    "PLT32 to libc": (copies, {
        "text": b"\xe9" + RIP, "symbols": [F, MEMCPY], "relocations": [(TEXT, 1, 4, 2, -4)],
    }),
    # lea rax, [rip + word]; add rax, [rax]; ret, where the word says how far the other is
    "PC64": (points, {
        "text": b"\x48\x8d\x05" + RIP + b"\x48\x03\x00\xc3", "rodata": bytes(8), "data": WORD,
        "symbols": [F, (b"far", LOCAL, RODATA, 0), (b"word", LOCAL, DATA, 0)],
        "relocations": [(TEXT, 3, 2, 2, -4), (RODATA, 0, 24, 3, 0)],
    }),
    # mov rax, [rip + address]; ret
    "GOTPCREL": (points, {
        "text": b"\x48\x8b\x05" + RIP + b"\xc3", "data": bytes(8) + WORD,
        "symbols": [F, (b"word", GLOBAL, DATA, 8)], "relocations": [(TEXT, 3, 9, 2, -4)],
    }),
    # jmp [rip + address]
    "GOTPCRELX": (copies, {
        "text": b"\xff\x25" + RIP, "symbols": [F, MEMCPY], "relocations": [(TEXT, 2, 41, 2, -4)],
    }),
    "REX_GOTPCRELX": (points, {
        "text": b"\x48\x8b\x05" + RIP + b"\xc3", "rodata": WORD,
        "symbols": [F, (b"word", WEAK, RODATA, 0)], "relocations": [(TEXT, 3, 42, 2, -4)],
    }),
    "64": (points, {
        "text": b"\x48\x8b\x05" + RIP + b"\xc3", "data": bytes(8), "rodata": bytes(8) + WORD,
        "symbols": [F, (b"at", LOCAL, DATA, 0), (b"", LOCAL | 3, RODATA, 0)],
        "relocations": [(TEXT, 3, 2, 2, -4), (DATA, 0, 1, 3, 8)],
    }),
    "64 to libc": (copies, {
        "text": b"\xff\x25" + RIP, "data": bytes(8),
        "symbols": [F, (b"at", LOCAL, DATA, 0), MEMCPY],
        "relocations": [(TEXT, 2, 2, 2, -4), (DATA, 0, 1, 3, 0)],
    }),
    # mov dword [rip + zero], 1234567 (4 bytes follow the place); mov eax, [rip + zero]; ret
    "zeros": (returns, {
        "text": b"\xc7\x05" + RIP + WORD[:4] + b"\x8b\x05" + RIP + b"\xc3", "zeros": 8192,
        "symbols": [F, (b"zero", LOCAL, BSS, 8000)],
        "relocations": [(TEXT, 2, 2, 2, -8), (TEXT, 12, 2, 2, -4)],
    }),
}  # fmt: skip


@pytest.mark.parametrize("name", KNOWN)
def test_what_it_links_runs(name: str, tmp_path: Path) -> None:
    right, words = KNOWN[name]
    assert right(loaded(tmp_path, made(**words)).f)


def test_it_hands_on_what_is_global(tmp_path: Path) -> None:
    symbols = [
        (b"hidden", LOCAL, TEXT, 0),
        (b"f", GLOBAL, TEXT, 0),
        (b"g", WEAK, TEXT, 6),
        (b"number", GLOBAL, ABSOLUTE, 77),
    ]
    library = loaded(tmp_path, made(b"\xb8\1\0\0\0\xc3\xb8\2\0\0\0\xc3", symbols))
    assert library.f() == 1
    assert library.g() == 2
    with pytest.raises(AttributeError):
        _ = library.hidden


REFUSED: list[tuple[str, dict[str, Any]]] = [
    ("relocation 11 in .text", {
        "text": RIP, "symbols": [F], "relocations": [(TEXT, 0, 11, 1, 0)],
    }),
    ("relocation 1 in .rodata", {
        "rodata": WORD, "symbols": [F], "relocations": [(RODATA, 0, 1, 1, 0)],
    }),
    ("machine 183", {"machine": 183}),
    ("undefined symbol puts", {"symbols": [(b"puts", GLOBAL, 0, 0)]}),
    ("section .more", {"section": (PROGBITS, ALLOC | WRITE | TLS)}),
    ("section .more", {"section": (INIT_ARRAY, ALLOC | WRITE)}),
    ("the kind of symbol chosen", {"symbols": [(b"chosen", GLOBAL | 10, TEXT, 0)]}),
    ("where symbol common is", {
        "text": RIP, "symbols": [(b"common", GLOBAL, COMMON, 8)],
        "relocations": [(TEXT, 0, 2, 1, 0)],
    }),
    ("where symbol  is", {"text": RIP, "relocations": [(TEXT, 0, 2, 0, 0)]}),
    ("the address of number", {
        "text": RIP, "symbols": [(b"number", GLOBAL, ABSOLUTE, 8)],
        "relocations": [(TEXT, 0, 9, 1, 0)],
    }),
    ("format requires", {
        "text": RIP, "symbols": [F], "relocations": [(TEXT, 0, 2, 1, 2**40)],
    }),
]  # fmt: skip


@pytest.mark.parametrize(("reason", "words"), REFUSED)
def test_what_it_refuses(reason: str, words: dict[str, Any]) -> None:
    with pytest.raises(linker.RefusedError, match=reason):
        linker.linked(made(**words))


def test_a_file_cut_short_is_refused_or_whole() -> None:
    whole = made(**KNOWN["64"][1])
    for size in range(len(whole)):
        with pytest.raises(linker.RefusedError):
            linker.linked(whole[:size])


def start(words: list[str], path: Path) -> "subprocess.CompletedProcess[str]":
    """Starts it as PoCL does."""
    with pocl.linking():
        command = Path(os.environ["COMPILER_PATH"].split(os.pathsep)[0]) / "ld"
    environment = {**os.environ, "PATH": str(path)}
    return subprocess.run([command, *words], env=environment, capture_output=True, text=True)


def test_the_systems_ld_does_what_it_refuses(tmp_path: Path) -> None:
    (tmp_path / "a.o").write_bytes(made(symbols=[(b"puts", GLOBAL, 0, 0)]))
    words = ["-shared", "-m", "elf_x86_64", "-o", "a.so", str(tmp_path / "a.o"), "-lc"]
    said = start(words, tmp_path)
    assert said.returncode == 1
    expected = "clrt's linker refuses undefined symbol puts, and there is no ld"
    assert said.stderr.strip() == expected
    (tmp_path / "ld").write_text('#!/bin/sh\necho "$@"\n')
    (tmp_path / "ld").chmod(0o755)
    assert start(words, tmp_path).stdout.split() == words
    two = ["-shared", "a.o", "b.o"]
    assert start(two, tmp_path).stdout.split() == two


def test_what_it_links_needs_no_path(tmp_path: Path) -> None:
    (tmp_path / "a.o").write_bytes(made(**KNOWN["PC32"][1]))
    words = ["-shared", "-o", str(tmp_path / "a.so"), str(tmp_path / "a.o"), "-lgcc"]
    assert start(words, tmp_path / "none").returncode == 0
    assert returns(ctypes.CDLL(str(tmp_path / "a.so")).f)


def test_the_variable_is_put_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COMPILER_PATH", raising=False)
    with pocl.linking():
        pass
    assert "COMPILER_PATH" not in os.environ
    monkeypatch.setenv("COMPILER_PATH", "/mine")
    with pocl.linking():
        assert os.environ["COMPILER_PATH"].endswith("/bin:/mine")
    assert os.environ["COMPILER_PATH"] == "/mine"


@pytest.mark.skipif(not shutil.which("gcc"), reason="GNU ld and gcc's libraries")
def test_pictures_are_those_of_gnu_ld(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = clrt.load_scene("four-spheres")
    scene = replace(scene, samples=5)
    source, films = program.kernel_source(), []

    def made_here(device: Any, source: str, wanted: Any, waiting: Any) -> list[bytes]:
        return [trial.try_here(device, source, features) for features in wanted]

    monkeypatch.setattr(maker, "made", made_here)  # in this process, which is told how
    for name in ("ours", "gnu"):
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / name))
        # PoCL, which keeps what it has linked, does not know it.
        monkeypatch.setattr(program, "kernel_source", lambda name=name: f"// {name}\n{source}")
        films.append(clrt.Renderer(lanes=4).render(scene, 64, 36))
        monkeypatch.setattr(pocl, "linking", nullcontext)
    assert np.array_equal(films[0], films[1])


def test_a_warm_command_starts_nothing(tmp_path: Path) -> None:
    """No process: one that the command had waited for would have had memory."""
    code = (
        "import atexit, resource\n"
        "from clrt.__main__ import main\n"
        "atexit.register(lambda: print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss))\n"
        "main()"
    )
    words = ["render", "--lanes", "4", "--samples", "5", "--width", "65", "--height", "37"]
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path)}
    started = [
        int(subprocess.check_output(
            [sys.executable, "-c", code, *words], cwd=tmp_path, env=environment
        ))
        for _ in range(2)
    ]  # fmt: skip
    assert started[0] > 0
    assert started[1] == 0
