"""A figure with all kinds of words, rendered to words.png: twelve labels in three alphabets."""

import numpy as np

import clrt

NAMES = ("Na⁺", "Cl⁻", "H₂O", "Å", "α", "β", "σ²", "Ω", "Ж", "И", "Ю", "µ")  # noqa: RUF001

golden = np.pi * (3 - np.sqrt(5))
k = np.arange(120)
height = 1 - 2 * (k + 0.5) / 120
ring = np.sqrt(1 - height**2)
positions = 10 * np.stack([ring * np.cos(k * golden), ring * np.sin(k * golden), height], axis=1)
towards = positions @ (0.43, -0.75, 0.5)
named = np.full(120, "", "U8")
named[np.argsort(-towards)[:24:2]] = NAMES

particles = clrt.Particles(
    positions,
    radii=0.9,
    values={"v": 10.0 ** (height + 0.05)},
    texts={"name": named},
    cell=24 * np.eye(3),
    origin=(-12.0, -12.0, -12.0),
    unit="angstrom",
    facts={"time": 2.5},
)
picture = clrt.plot(
    particles,
    color="log10(v)",
    colorbar=r"speed $v_x/\sqrt{gd}$ (Å/ps)",
    clim=(-0.8, 0.8),
    cell=True,
    title="Φ = 0.25 ± 0.01, T = 300 K, 10⁻³ µm² × √2 → ∞",  # noqa: RUF001
    label="t = {time:.1f} ps",
    labels="name",
    scalebar="auto",
    axes="abc",
    line_width="1pt/170mm",
    font_size="8pt/170mm",
    size=(1200, 675),
)
picture.save("words.png")
