"""The look of all charts and drawings that scripts make with Matplotlib. An opaque pale ground keeps them readable on light and
dark pages; text stays text, and the same numbers give the same bytes."""
import pathlib
import re

import matplotlib

matplotlib.use("svg")
from matplotlib import pyplot, ticker, transforms  # noqa: E402

GROUND, INK, FAINT, GRID = "#fcfcfa", "#22252a", "#5c636e", "#e3e4e0"
BLUE, ORANGE, GREEN, VIOLET, RED, GREY = "#2a6fc9", "#d9622b", "#14906a", "#6a4bb5", "#c2334d", "#7c828c"

pyplot.rcParams.update({
    "figure.facecolor": GROUND, "figure.constrained_layout.use": True, "figure.constrained_layout.w_pad": 0.12, "figure.constrained_layout.h_pad": 0.1, "savefig.facecolor": GROUND, "svg.fonttype": "none",
    "svg.hashsalt": "sqmap", "font.family": "sans-serif", "font.sans-serif": ["Helvetica", "Arial", "DejaVu Sans"], "font.size": 9,
    "axes.facecolor": GROUND, "axes.edgecolor": GREY, "axes.labelcolor": INK, "axes.titlelocation": "left", "axes.titlesize": 10.5,
    "axes.titleweight": "bold", "axes.titlecolor": INK, "axes.spines.top": False, "axes.spines.right": False,
    "axes.spines.left": False, "axes.grid": True, "axes.grid.axis": "y", "axes.axisbelow": True, "grid.color": GRID,
    "xtick.color": GREY, "ytick.color": GREY, "xtick.labelcolor": FAINT, "ytick.labelcolor": FAINT, "ytick.major.size": 0,
    "text.color": INK, "lines.linewidth": 1.4, "lines.markersize": 5.5, "lines.markeredgewidth": 1.3, "legend.frameon": False,
    "legend.fontsize": 8, "legend.columnspacing": 1.2, "legend.handlelength": 2.2})


def panels(*labels, width=5.2, height=4.0, stacked=False):
    """A figure with a panel for each (title, words of x, words of y), side by side or one below the other; inches."""
    rows, columns = (len(labels), 1) if stacked else (1, len(labels))
    figure, axes = pyplot.subplots(rows, columns, figsize=(width * columns, height * rows), squeeze=False)
    for axis, (title, x, y) in zip(axes.flat, labels):
        axis.set(title=title, xlabel=x, ylabel=y)
    return figure, axes.ravel()


def marks(colour, marker="o", hollow=False):
    """Options of plot() for points without a line."""
    return {"color": colour, "marker": marker, "linestyle": "none", "markerfacecolor": GROUND if hollow else colour}


def log_ticks(axis):
    """Ticks at round values, the fewer to a decade the more decades there are; words without exponents."""
    low, high = axis.get_data_interval()
    if not isinstance(axis.get_major_locator(), ticker.FixedLocator):
        steps = next((s for ratio, s in ((8, (1, 1.5, 2, 3, 5, 7)), (2000, (1, 2, 5)), (1e5, (1, 3))) if high < ratio * low), (1,))
        axis.set_major_locator(ticker.LogLocator(subs=steps, numticks=99))
    axis.set_major_formatter(ticker.FuncFormatter(lambda value, _: f"{value:,.0f}" if value >= 1000 else f"{value:g}"))
    axis.set_minor_locator(ticker.NullLocator())


def save(path, figure):
    """Writes the figure, a legend of two columns below each panel that names its series; below all of them where they name the same."""
    named = [axes for axes in figure.axes if axes.get_legend_handles_labels()[1]]
    shared = len(named) > 1 and len({tuple(axes.get_legend_handles_labels()[1]) for axes in named}) == 1
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if axis.get_scale() == "log":
                log_ticks(axis)
    for axes in named[:1] if shared else named:
        if shared:  # in three columns, in a strip that the figure gains
            names = axes.get_legend_handles_labels()[1]
            columns = 3 if max(map(len, names)) < 40 else 2
            gained = 0.165 * -(-len(names) // columns) + 0.1
            figure.set_figheight(figure.get_figheight() + gained)
            strip = gained / figure.get_figheight()
            figure.get_layout_engine().set(rect=(0, strip, 1, 1 - strip))
            legend = figure.legend(*axes.get_legend_handles_labels(), loc="lower center", ncols=columns)
        else:
            below = transforms.offset_copy(axes.transAxes, figure, y=-32 if axes.get_xlabel() else -18, units="points")
            legend = axes.legend(loc="upper center", bbox_to_anchor=(0.5, 0), bbox_transform=below, ncols=2)
        for mark in legend.get_lines():  # also of the small and pale
            mark.set(alpha=1, markersize=max(5, mark.get_markersize()))
    figure.savefig(path, metadata={"Creator": None, "Date": None, "Format": None, "Type": None})
    pyplot.close(figure)
    path = pathlib.Path(path)
    path.write_text(compact(path.read_text(encoding="utf-8")), encoding="utf-8")


def compact(svg):
    """Paths on one line each, in hundredths of a point: Matplotlib gives a line to each corner, in millionths. The marks of a series
    are one line, their common style said once."""
    def shorter(text):
        return re.sub(r"\d+\.\d{3,}", lambda number: f"{float(number[0]):.2f}", " ".join(text[0].split()))

    def joined(marks):
        style = re.search(r' style="[^"]*"', marks[2])
        if style is None or marks[2].count(style[0]) != marks[2].count("<use"):
            return marks[0]
        return marks[1] + style[0] + ">" + re.sub(r">\s+<", "><", marks[2].replace(style[0], ""))

    svg = re.sub(r'(?<= d=)"[^"]*"|(?<= [xy]=)"[^"]*"', shorter, "\n".join(line.rstrip() for line in svg.split("\n")))
    return re.sub(r"(<g[^>]*)>\n\s*((?:<use [^>]*/>\s*){2,})", joined, svg)
