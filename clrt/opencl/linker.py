"""The linker: one object of x86-64 into a shared library, which is all that PoCL asks of `ld`.

PoCL starts a linker for each kernel and hands it an object, whose code stands on its own, and the
names of gcc's libraries. So a machine without gcc and libc's development files could not render.
clrt lets PoCL start this module instead (clrt/opencl/pocl.py: linking()); where it refuses it
starts the system's `ld` with the same words.

In: a relocatable file of ELF with 64 bits. Out: a shared library of two segments, one to read and
run and one to write, as dlopen() needs it: no section headers, no symbols but the dynamic ones, no
unwinding (.eh_frame is left out: nobody throws). Sources: System V ABI, chapters 4 and 5, and its
AMD64 supplement, section 4.4.

It knows the relocations PC32, PLT32, PC64, GOTPCREL, GOTPCRELX, REX_GOTPCRELX, and 64 in words that
can be written. LIBC names what may be undefined: it is in every process of Python's. It refuses
other files, other relocations and names, thread-local variables, constructors and common symbols.

It costs what Python's start does, 7 of 8 ms (benchmarks/NOTES.md), so it imports nothing that takes
time: no typing, no os unless it refuses.
"""

import struct
import sys

LIBC = {b"memcpy", b"memmove", b"memset", b"memcmp"}
PAGE = 4096

# The names that ELF has for them.
ET_REL, ET_DYN, EM_X86_64 = 1, 3, 62
SHT_PROGBITS, SHT_SYMTAB, SHT_RELA, SHT_NOTE, SHT_NOBITS = 1, 2, 4, 7, 8
SHT_UNWIND = 0x70000001
SHF_WRITE, SHF_ALLOC, SHF_TLS = 1, 2, 0x400
SHN_UNDEF, SHN_ABS, SHN_RESERVED = 0, 0xFFF1, 0xFF00
STT_TLS, STT_GNU_IFUNC = 6, 10
R_64, R_PC32, R_PLT32, R_GLOB_DAT, R_RELATIVE, R_GOTPCREL, R_PC64 = 1, 2, 4, 6, 8, 9, 24
R_GOTPCRELX, R_REX_GOTPCRELX = 41, 42
PT_LOAD, PT_DYNAMIC, PT_GNU_STACK = 1, 2, 0x6474E551
DT_HASH, DT_STRTAB, DT_SYMTAB, DT_RELA, DT_RELASZ, DT_RELAENT, DT_STRSZ, DT_SYMENT = (
    4, 5, 6, 7, 8, 9, 10, 11,
)  # fmt: skip
HEADER, SEGMENT, SECTION, SYMBOL, RELOCATION = map(
    struct.Struct, ("<16s2HI3QI6H", "<2I6Q", "<2I4Q2I2Q", "<I2BH2Q", "<2Qq")
)
SEGMENTS = 4
JUMP = b"\xff\x25\0\0\0\0\x66\x90"  # jmp *word(%rip), and a nop


class RefusedError(Exception):
    """What this linker does not do."""


class Section:
    def __init__(self, words: tuple[int, ...]) -> None:
        (self.name_at, self.kind, self.flags, _, self.offset,
         self.size, self.link, self.info, self.align, _) = words  # fmt: skip
        self.name = b""
        self.address = -1  # in the library, once it is placed


class Symbol:
    def __init__(self, words: tuple[int, ...], name: bytes) -> None:
        _, self.info, self.visibility, self.section, self.value, self.size = words
        self.name = name
        self.stub = -1  # where the jump to what is undefined is
        self.word = -1  # where the word with its address is

    @property
    def is_local(self) -> bool:
        return self.info >> 4 == 0


class Object:
    """Sections and symbols of a relocatable file.

    Raises:
        RefusedError: it is none, or has what a library of one object does not need.
    """

    def __init__(self, content: bytes) -> None:
        if content[:7] != b"\x7fELF\x02\x01\x01":
            raise RefusedError("no ELF file of 64 bits")
        _, kind, machine, _, _, _, at, _, _, _, _, _, count, names = HEADER.unpack_from(content)
        if (kind, machine) != (ET_REL, EM_X86_64):
            raise RefusedError(f"type {kind} of machine {machine}, no object of x86-64")
        self.content = content
        self.sections = [
            Section(SECTION.unpack_from(content, at + i * SECTION.size)) for i in range(count)
        ]
        for section in self.sections:
            section.name = self._text(self.sections[names], section.name_at)
        self.symbols: list[Symbol] = []
        for table in self.sections:
            if table.kind == SHT_SYMTAB:
                names_of = self.sections[table.link]
                for words in SYMBOL.iter_unpack(self.bytes_of(table)):
                    self.symbols.append(Symbol(words, self._text(names_of, words[0])))

    def bytes_of(self, section: Section) -> bytes:
        if section.kind == SHT_NOBITS:
            return bytes(section.size)
        return self.content[section.offset : section.offset + section.size]

    def _text(self, table: Section, at: int) -> bytes:
        start = table.offset + at
        return self.content[start : self.content.index(b"\0", start)]

    def loaded(self) -> list[Section]:
        """Those that are part of a running program."""
        found = []
        for section in self.sections:
            if not section.flags & SHF_ALLOC or section.kind == SHT_NOTE:
                continue
            if section.name == b".eh_frame" or section.kind == SHT_UNWIND:
                continue
            known = section.kind in (SHT_PROGBITS, SHT_NOBITS) and section.align <= PAGE
            if not known or section.flags & SHF_TLS:
                raise RefusedError(f"section {section.name.decode()}")
            found.append(section)
        return found


class Library:
    """A shared library, laid out and filled."""

    def __init__(self, source: Object) -> None:
        self.source = source
        self.image = bytearray(HEADER.size + SEGMENTS * SEGMENT.size)
        self.relocations: list[tuple[int, int, int]] = []  # what is left to the loader
        loaded = source.loaded()
        for section in loaded:
            if not section.flags & SHF_WRITE:
                section.address = self.place(source.bytes_of(section), section.align)
        # Null comes first, in the object and in the library.
        undefined = [s for s in source.symbols[1:] if s.section == SHN_UNDEF]
        for symbol in undefined:
            if symbol.name not in LIBC:
                raise RefusedError(f"undefined symbol {symbol.name.decode()}")
            symbol.stub = self.place(JUMP, 8)
        self.run_end = len(self.image)
        self.write_start = self.place(b"", PAGE)
        for section in loaded:
            if section.flags & SHF_WRITE:
                section.address = self.place(source.bytes_of(section), section.align)
        for symbol in source.symbols:
            if symbol.info & 15 in (STT_TLS, STT_GNU_IFUNC):
                raise RefusedError(f"the kind of symbol {symbol.name.decode()}")
        exported = [
            s for s in source.symbols
            if s.section != SHN_UNDEF and not s.is_local and s.visibility & 3 == 0
        ]  # fmt: skip
        self.dynamic = undefined + exported
        self.numbers = {id(symbol): i for i, symbol in enumerate(self.dynamic, 1)}
        for symbol in undefined:
            self._pack("<i", symbol.stub + 2, self.word_of(symbol) - (symbol.stub + 6))
        for table in source.sections:
            target = source.sections[table.info] if table.kind == SHT_RELA else None
            if target is not None and target.address >= 0:
                for words in RELOCATION.iter_unpack(source.bytes_of(table)):
                    self.relocate(target, *words)

    def place(self, content: bytes, align: int) -> int:
        """Appends; returns where, which is both the address and the place in the file."""
        self.image.extend(bytes(-len(self.image) % max(align, 1)))
        self.image.extend(content)
        return len(self.image) - len(content)

    def _pack(self, form: str, at: int, value: int) -> None:
        struct.pack_into(form, self.image, at, value)

    def address_of(self, symbol: Symbol) -> int:
        if symbol.section == SHN_UNDEF and symbol.stub >= 0:
            return symbol.stub
        if symbol.section == SHN_ABS:
            return symbol.value
        if SHN_UNDEF < symbol.section < SHN_RESERVED:
            section = self.source.sections[symbol.section]
            if section.address >= 0:
                return section.address + symbol.value
        raise RefusedError(f"where symbol {symbol.name.decode()} is")

    def left_to_loader(self, at: int, symbol: Symbol, kind: int, addend: int) -> None:
        """Has the loader write a symbol's address."""
        if symbol.section == SHN_UNDEF:
            self.relocations.append((at, self.numbers[id(symbol)] << 32 | kind, addend))
        elif symbol.section == SHN_ABS:
            raise RefusedError(f"the address of {symbol.name.decode()}")
        else:
            self.relocations.append((at, R_RELATIVE, self.address_of(symbol) + addend))

    def word_of(self, symbol: Symbol) -> int:
        """Where a symbol's address stands, in the global offset table."""
        if symbol.word < 0:
            symbol.word = self.place(bytes(8), 8)
            self.left_to_loader(symbol.word, symbol, R_GLOB_DAT, 0)
        return symbol.word

    def relocate(self, target: Section, offset: int, info: int, addend: int) -> None:
        kind, symbol, at = info & 0xFFFFFFFF, self.source.symbols[info >> 32], target.address
        at += offset
        if kind in (R_PC32, R_PLT32):
            self._pack("<i", at, self.address_of(symbol) + addend - at)
        elif kind in (R_GOTPCREL, R_GOTPCRELX, R_REX_GOTPCRELX):
            self._pack("<i", at, self.word_of(symbol) + addend - at)
        elif kind == R_PC64:
            self._pack("<q", at, self.address_of(symbol) + addend - at)
        elif kind == R_64 and target.flags & SHF_WRITE:
            self.left_to_loader(at, symbol, R_64, addend)
        else:
            raise RefusedError(f"relocation {kind} in {target.name.decode()}")

    def finished(self) -> bytes:
        """The file: what the loader reads comes last, then the headers are filled in."""
        names, table = b"\0", bytes(SYMBOL.size)
        for symbol in self.dynamic:
            is_here = symbol.section != SHN_UNDEF
            address = self.address_of(symbol) if is_here else 0
            section = (SHN_ABS if symbol.section == SHN_ABS else 1) if is_here else SHN_UNDEF
            table += SYMBOL.pack(len(names), symbol.info, 0, section, address, symbol.size)
            names += symbol.name + b"\0"
        # One bucket: the loader goes through the few symbols from the last to the first.
        last = len(self.dynamic)
        chain = struct.pack(f"<{last + 4}I", 1, last + 1, last, 0, *range(last))
        entries = [
            (DT_HASH, self.place(chain, 8)),
            (DT_SYMTAB, self.place(table, 8)),
            (DT_SYMENT, SYMBOL.size),
            (DT_STRTAB, self.place(names, 1)),
            (DT_STRSZ, len(names)),
        ]
        if self.relocations:
            packed = b"".join(RELOCATION.pack(*words) for words in self.relocations)
            entries += [
                (DT_RELA, self.place(packed, 8)),
                (DT_RELASZ, len(packed)),
                (DT_RELAENT, RELOCATION.size),
            ]
        content = b"".join(struct.pack("<2Q", *entry) for entry in [*entries, (0, 0)])
        dynamic, end = self.place(content, 8), len(self.image)
        head = b"\x7fELF\x02\x01\x01"
        at, size, each = HEADER.size, HEADER.size, SEGMENT.size
        HEADER.pack_into(
            self.image, 0, head, ET_DYN, EM_X86_64, 1, 0, at, 0, 0, size, each, SEGMENTS, 0, 0, 0
        )
        readable, writable, runnable = 4, 2, 1
        both = readable | writable
        for kind, flags, start, stop, align in (
            (PT_LOAD, readable | runnable, 0, self.run_end, PAGE),
            (PT_LOAD, both, self.write_start, end, PAGE),
            (PT_DYNAMIC, both, dynamic, end, 8),
            (PT_GNU_STACK, both, 0, 0, 16),
        ):
            length = stop - start
            SEGMENT.pack_into(
                self.image, at, kind, flags, start, start, start, length, length, align
            )
            at += each
        return bytes(self.image)


def linked(content: bytes) -> bytes:
    """A shared library of an object.

    Raises:
        RefusedError: see the top.
    """
    try:
        return Library(Object(content)).finished()
    except (struct.error, LookupError, ValueError) as error:  # cut short; too far for 32 bits
        raise RefusedError(str(error)) from None


def main(words: list[str]) -> None:
    """Does as `ld` does with these words, or starts it."""
    try:
        inputs, output, rest = [], "a.out", iter(words)
        for word in rest:
            if word == "-o":
                output = next(rest)
            elif word in ("-m", "-z", "-soname", "-rpath", "-dynamic-linker", "-plugin"):
                next(rest)
            elif not word.startswith("-"):
                inputs.append(word)
        if "-shared" not in words or len(inputs) != 1:
            raise RefusedError(" ".join(words))
        with open(inputs[0], "rb") as file:
            library = linked(file.read())
    except RefusedError as error:
        _system(words, str(error))
    else:
        with open(output, "wb") as file:
            file.write(library)


def _system(words: list[str], reason: str) -> None:
    import os

    try:
        os.execvp("ld", ["ld", *words])
    except OSError:
        sys.exit(f"clrt's linker refuses {reason}, and there is no ld")
