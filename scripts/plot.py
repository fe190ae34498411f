"""Small charts as SVG, with nothing but the standard library. An opaque pale ground keeps them readable on light and dark pages."""
import html
import math

GROUND, INK, FAINT, GRID = "#fcfcfa", "#22252a", "#5c636e", "#e3e4e0"
BLUE, ORANGE, GREEN, VIOLET, RED, GREY = "#2a6fc9", "#d9622b", "#14906a", "#6a4bb5", "#c2334d", "#7c828c"
FONT = "font-family='Helvetica,Arial,sans-serif'"


def number(value):
    """A tick's words: no more digits than it needs."""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.6g}"


def linear_ticks(low, high, count=6):
    step = 10 ** math.floor(math.log10((high - low) / count))
    step = next(s * step for s in (1, 2, 5, 10) if (high - low) / (s * step) <= count)
    first = math.ceil(low / step - 1e-9)
    return [i * step for i in range(first, int(math.floor(high / step + 1e-9)) + 1)]


def log_ticks(low, high):
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for steps in ((1, 2, 5), (1, 3), (1,)):
        ticks = [s * 10.0**d for d in decades for s in steps if low * 0.999 <= s * 10.0**d <= high * 1.001]
        if len(ticks) <= 9:
            break
    return ticks


def markers(shape, places, colour, hollow, size=4, opacity=1):
    """The marks of a series as one group, which holds their paint."""
    s = size * 1.35
    mark = {
        "dash": lambda x, y: f"<path d='M{x - 9:.1f} {y:.1f}h18'/>",
        "square": lambda x, y: f"<rect x='{x - size:.1f}' y='{y - size:.1f}' width='{2 * size}' height='{2 * size}'/>",
        "diamond": lambda x, y: f"<path d='M{x:.1f} {y - s:.1f}l{s} {s}l-{s} {s}l-{s} -{s}z'/>",
        "circle": lambda x, y: f"<circle cx='{x:.1f}' cy='{y:.1f}' r='{size}'/>",
    }[shape]
    return (f"<g fill='{GROUND if hollow else colour}' stroke='{colour}' stroke-width='1.6' opacity='{opacity}'>"
            + "".join(mark(x, y) for x, y in places) + "</g>")


class Chart:
    """One panel. Series are added in the order of the legend; points are (x, y), or (category, y) where categories are given."""

    def __init__(self, title, x, y, *, x_log=False, y_log=False, x_ticks=None, categories=None, y_from_zero=False, width=520,
                 height=400):
        self.title, self.x_label, self.y_label = title, x, y
        self.x_log, self.y_log, self.x_ticks, self.categories = x_log, y_log, x_ticks, categories
        self.y_from_zero, self.width, self.height = y_from_zero, width, height
        self.series, self.levels = [], []

    def line(self, name, points, colour, *, dashed=False, shape=None, hollow=False, width=1.8):
        self.series.append(dict(name=name, points=points, colour=colour, stroke=width, dashed=dashed, shape=shape, hollow=hollow))

    def dots(self, name, points, colour, *, shape="circle", hollow=False, size=4, opacity=1, label=False):
        """label: the name beside the points instead of in the legend."""
        self.series.append(dict(name=name, points=points, colour=colour, stroke=0, shape=shape, hollow=hollow, size=size,
                                opacity=opacity, label=label))

    def level(self, value, words):
        """A horizontal line with words on it."""
        self.levels.append((value, words))

    def scales(self, left, top, right, bottom):
        def scale(values, log, low_px, high_px, pad):
            if log:
                low, high = math.log10(min(values)), math.log10(max(values))
            else:
                low, high = min(values), max(values)
            span = high - low or abs(high) or 1
            low, high = low - pad * span, high + pad * span
            def place(v):
                return low_px + ((math.log10(v) if log else v) - low) / (high - low) * (high_px - low_px)
            return place, (10**low, 10**high) if log else (low, high)

        ys = [y for s in self.series for _, y in s["points"]] + [v for v, _ in self.levels]
        if self.y_from_zero:
            ys.append(0)
        y_place, y_range = scale(ys, self.y_log, bottom, top, 0 if self.y_from_zero else 0.05)
        if self.y_from_zero:
            y_place, y_range = scale([0, 1.06 * max(ys)], False, bottom, top, 0)
        if self.categories:
            step = (right - left) / len(self.categories)
            return lambda c: left + step * (self.categories.index(c) + 0.5), None, y_place, y_range
        xs = [x for s in self.series for x, _ in s["points"]]
        x_place, x_range = scale(xs, self.x_log, left, right, 0.04 if self.x_log else 0.01)
        return x_place, x_range, y_place, y_range

    def labels(self, x, y, right):
        """Of labelled points: (where, (where its words go, words, colour)); words are moved down past each other."""
        found = sorted(((x(a), y(b), s["name"], s["colour"]) for s in self.series if s.get("label") for a, b in s["points"]),
                       key=lambda p: p[1])
        placed = []
        for px, py, words, colour in found:
            length = 6 * len(words)
            to_right = px + 9 + length < right
            at = [px + 9 if to_right else px - 9, py + 3.5]
            span = lambda q, words, px: (q[0], q[0] + 6 * len(words)) if q[0] >= px else (q[0] - 6 * len(words), q[0])
            for (other_x, _), (other, other_words, _) in sorted(placed, key=lambda p: p[1][0][1]):
                a, b = span(at, words, px), span(other, other_words, other_x)
                if a[0] < b[1] and b[0] < a[1] and abs(at[1] - other[1]) < 11:
                    at[1] = other[1] + 11
            placed.append(((px, py), (at, words, colour)))
        return placed

    def draw(self, at_x):
        legend = [s for s in self.series if s["name"] and not s.get("label")]
        columns = 2
        rows = math.ceil(len(legend) / columns)
        left, right = at_x + 66, at_x + self.width - 14
        top, bottom = 40, self.height - 52 - 17 * rows
        x, x_range, y, y_range = self.scales(left, top, right, bottom)
        out = [f"<text x='{at_x + 14}' y='22' font-size='14' font-weight='bold' fill='{INK}'>{html.escape(self.title)}</text>"]

        def text(px, py, words, anchor="middle", extra="", colour=FAINT, size=11):
            out.append(f"<text x='{px:.1f}' y='{py:.1f}' font-size='{size}' fill='{colour}' text-anchor='{anchor}' {extra}>"
                       f"{html.escape(words)}</text>")

        for tick in log_ticks(*y_range) if self.y_log else linear_ticks(*y_range):
            out.append(f"<path d='M{left} {y(tick):.1f}H{right}' stroke='{GRID}'/>")
            text(left - 7, y(tick) + 4, number(tick), "end")
        if self.categories:
            for category in self.categories:
                text(x(category), bottom + 17, category)
        else:
            for tick in self.x_ticks or (log_ticks(*x_range) if self.x_log else linear_ticks(*x_range)):
                out.append(f"<path d='M{x(tick):.1f} {bottom}v5' stroke='{GREY}'/>")
                text(x(tick), bottom + 17, number(tick))
        out.append(f"<path d='M{left} {bottom}H{right}' stroke='{GREY}'/>")
        text((left + right) / 2, bottom + 35, self.x_label, colour=INK, size=12)
        middle = (top + bottom) / 2
        text(at_x + 16, middle, self.y_label, extra=f"transform='rotate(-90 {at_x + 16} {middle:.1f})'", colour=INK, size=12)
        for value, words in self.levels:
            out.append(f"<path d='M{left} {y(value):.1f}H{right}' stroke='{INK}' stroke-dasharray='5 4'/>")
            between = left + (right - left) / len(self.categories) if self.categories else left + 30
            text(between, y(value) - 5, words, colour=INK)
        for s in self.series:
            places = [(x(a), y(b)) for a, b in s["points"]]
            if s["stroke"]:
                path = "L".join(f"{a:.1f} {b:.1f}" for a, b in places)
                dash = " stroke-dasharray='6 4'" if s["dashed"] else ""
                out.append(f"<path d='M{path}' fill='none' stroke='{s['colour']}' stroke-width='{s['stroke']}' "
                           f"stroke-linejoin='round'{dash}/>")
            if s["shape"]:
                out.append(markers(s["shape"], places, s["colour"], s["hollow"], s.get("size", 4), s.get("opacity", 1)))
        for (px, py), (at, words, colour) in self.labels(x, y, right):
            side = "start" if at[0] >= px else "end"
            out.append(f"<path d='M{px:.1f} {py:.1f}L{at[0]:.1f} {at[1] - 3.5:.1f}' stroke='{colour}' stroke-width='0.7'/>")
            text(at[0] + (2 if side == "start" else -2), at[1], words, side, colour=INK, size=10)
        for i, s in enumerate(legend):
            px = left - 20 + (right - left + 20) / columns * (i % columns)
            py = self.height - 17 * rows + 17 * (i // columns) + 1
            if s["stroke"]:
                dash = " stroke-dasharray='5 3'" if s["dashed"] else ""
                out.append(f"<path d='M{px} {py - 4}h20' stroke='{s['colour']}' stroke-width='{s['stroke']}'{dash}/>")
            if s["shape"]:
                out.append(markers(s["shape"], [(px + 10, py - 4)], s["colour"], s["hollow"], min(s.get("size", 4), 4)))
            text(px + 27, py, s["name"], "start", colour=INK, size=11.5)
        return "\n".join(out)


def svg(width, height, body):
    return (f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width} {height}' width='{width}' height='{height}' {FONT}>\n"
            f"<rect width='{width}' height='{height}' rx='8' fill='{GROUND}'/>\n{body}\n</svg>\n")


def save(path, *charts):
    """Panels side by side."""
    at, bodies = 0, []
    for chart in charts:
        bodies.append(chart.draw(at))
        at += chart.width
    path.write_text(svg(at, max(c.height for c in charts), "\n".join(bodies)))


def save_meshes(path, panels, size=420):
    """Wire pictures side by side: panels of (title, grid), grid[i][j] = (x, y, z) with rows closed around j. Hidden quads are
    painted over."""
    turn, tilt = math.radians(32), math.radians(24)
    body = []
    for index, (title, grid) in enumerate(panels):
        def seen(p):
            a = math.cos(turn) * p[0] - math.sin(turn) * p[1]
            b = math.sin(turn) * p[0] + math.cos(turn) * p[1]
            return a, math.cos(tilt) * p[2] + math.sin(tilt) * b, math.sin(tilt) * p[2] - math.cos(tilt) * b
        flat = [[seen(p) for p in row] for row in grid]
        reach = max(max(abs(p[0]), abs(p[1])) for row in flat for p in row)
        scale = (size / 2 - 34) / reach
        quads = []
        for i in range(len(flat) - 1):
            for j in range(len(flat[i])):
                k = (j + 1) % len(flat[i])
                quad = [flat[i][j], flat[i][k], flat[i + 1][k], flat[i + 1][j]]
                (ax, ay, _), (bx, by, _), (cx, cy, _), (dx, dy, _) = quad
                if (cx - ax) * (dy - by) - (cy - ay) * (dx - bx) > 0:  # it faces the eye
                    quads.append((sum(p[2] for p in quad), quad))
        x0, y0 = size * index + size / 2, size / 2 + 22
        for _, quad in sorted(quads):
            points = " ".join(f"{x0 + scale * p[0]:.1f},{y0 - scale * p[1]:.1f}" for p in quad)
            body.append(f"<polygon points='{points}'/>")
        body.append(f"<text x='{size * index + 14}' y='24' font-size='14' font-weight='bold' fill='{INK}' stroke='none'>"
                    f"{html.escape(title)}</text>")
    drawn = f"<g fill='#dfe9f6' stroke='{BLUE}' stroke-width='0.6' stroke-linejoin='round'>" + "\n".join(body) + "</g>"
    path.write_text(svg(size * len(panels), size + 30, drawn))
