"""The thresholds that the paper leaves unstated."""
from __future__ import annotations

import inspect
from typing import Any, Optional, Tuple

from . import _library as c
from ._arrays import count, flag, option, refuse

_PAPER_WORDS = {"cuts": ("passes", "printed"), "mean_curvature": ("area", "count"), "smoothing": ("surface", "distances"),
                "smoothing_kernel": ("binomial", "box", "gaussian")}
_NOT_OF_SECTION_THREE = ("taper", "bend", "max_looseness", "max_q2", "grid", "subdivisions", "offset_constant", "offset_radius", "smoothing",
                         "smoothing_length", "smoothing_radius", "smoothing_kernel")


class PaperOptions:
    """Thresholds that the paper leaves unstated, for bake(paper=...): the options of `sqmap bake`, of the same names, defaults, ranges
    and effects (docs/paper-claims.md). None: the default.

    Sections 2 and 3, of models of either projection: taper, bend. cuts: "passes" or "printed", which has thresholds of its own.
    exact_geodesics: eq. 4 over every triangle, else over protrusion_sources. mean_curvature ("area", "count"), printed_strength and
    printed_curvature are of printed cuts. Section 4.1, of paper models: grid is (rows, columns) of layer 2, subdivisions A_S,
    offset_constant a_N. smoothing: "surface", or "distances" as section 6 has it; smoothing_length is of the surface,
    smoothing_radius and smoothing_kernel ("binomial", "box", "gaussian") are of distances; radius 0: no smoothed map."""

    def __init__(self, *, taper: bool = True, bend: bool = True, cuts: str = "passes", exact_geodesics: bool = False,
                 protrusion_sources: Optional[int] = None, salient_window: Optional[float] = None,
                 salient_prominence: Optional[float] = None, locale_width: Optional[float] = None,
                 boundary_strength: Optional[float] = None, protrusion_ratio: Optional[float] = None,
                 curvature_window: Optional[float] = None, hyperbolic_curvature: Optional[float] = None,
                 boundary_concavity: Optional[float] = None, curvature_floor: Optional[float] = None,
                 hyperbolic_share: Optional[float] = None, minimum_part: Optional[float] = None,
                 fragment_roundness: Optional[float] = None, mean_curvature: str = "area", printed_strength: Optional[float] = None,
                 printed_curvature: Optional[float] = None, max_looseness: Optional[float] = None, max_q2: Optional[float] = None,
                 grid: Optional[Tuple[int, int]] = None, subdivisions: Optional[int] = None, offset_constant: Optional[float] = None,
                 offset_radius: Optional[int] = None, smoothing: str = "surface", smoothing_length: Optional[float] = None,
                 smoothing_radius: Optional[int] = None, smoothing_kernel: str = "binomial") -> None:
        self._given = given = {name: value for name, value in locals().items() if name != "self"}
        self._struct = out = c.PaperOptions(without_taper=not flag(taper, "taper"), without_bend=not flag(bend, "bend"),
                                            exact_geodesics=flag(exact_geodesics, "exact_geodesics"))
        for name, words in _PAPER_WORDS.items():
            if not isinstance(given[name], str) or given[name] not in words:
                raise refuse(name, f"is {given[name]!r}", f"take one of {', '.join(words)}")
            setattr(out, name, words.index(given[name]))
        if grid is not None:
            if not isinstance(grid, (tuple, list)) or len(grid) != 2:
                raise refuse("grid", f"is {grid!r}", "give (rows, columns)")
            out.rows, out.columns = (count(side, "grid", 2**31 - 1) for side in grid)
            (least, most), (narrowest, widest) = c.option_range("rows"), c.option_range("columns")
            if not least <= out.rows <= most or not narrowest <= out.columns <= widest:
                raise refuse("grid", f"is {grid!r}", f"give {least:g} to {most:g} rows and {narrowest:g} to {widest:g} columns")
        for name, kind in c.PaperOptions._fields_:
            value = given.get(name)
            if value is None or name in _PAPER_WORDS or name == "exact_geodesics":
                continue
            setattr(out, name, option(value, name, kind is not c.c_double))

    def _of_section_three(self) -> list[tuple[str, Any]]:
        """The thresholds that were given, as `sqmap render` takes them. Raises ArgumentError for one of another section."""
        plain = {name: parameter.default for name, parameter in inspect.signature(PaperOptions).parameters.items()}
        changed = {name: value for name, value in self._given.items() if value != plain[name]}
        for name in changed:
            if name in _NOT_OF_SECTION_THREE:
                raise refuse(name, "changes no picture of section 3", "give it to bake")
        return [("--" + name.replace("_", "-"), value) for name, value in changed.items()]
