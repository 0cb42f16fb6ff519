#!/usr/bin/env bash
# gemmi 0.7.5 lists the atoms of a PDB file in another order than the file does where residue
# numbers of a chain begin anew, as they do for water after residue 9999: an atom joins the earlier
# residue of its number. Arrays in the order of the file (colours, charges, a trajectory) then
# belong to other atoms. The serial numbers tell: 1 4 2 5 3 6 for a file that has 1 2 3 4 5 6.
#
# Seen on 2026-11-28 with Python 3.11. This script fails if that changes.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install -q gemmi==0.7.5
venv/bin/python - <<'END'
import gemmi

numbers = [1, 2, 3, 1, 2, 3]  # of residues: six waters of one chain
with open("water.pdb", "w") as file:
    for serial, number in enumerate(numbers, 1):
        file.write(f"HETATM{serial:5d}  O   HOH A{number:4d}    {serial:8.3f}{0:8.3f}{0:8.3f}"
                   "  1.00  0.00           O\n")
    file.write("END\n")
structure = gemmi.read_structure("water.pdb")
serials = [atom.serial for chain in structure[0] for residue in chain for atom in residue]
print(f"gemmi {gemmi.__version__}: serials in the order of gemmi's atoms: {serials}")
assert serials == [1, 4, 2, 5, 3, 6], "gemmi's order has changed"
END
