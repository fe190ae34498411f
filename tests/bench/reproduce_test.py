#!/usr/bin/env python3
"""The reproduction's charts and page, without a run."""
import importlib.util
import pathlib
import sys
import tempfile
import unittest
import xml.etree.ElementTree as xml

if importlib.util.find_spec("matplotlib") is None:
    print("skipped: there is no Matplotlib (Debian: python3-matplotlib)")
    sys.exit(77)
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import plot
import reproduce
import reproduce_figures as figures

SVG = "{http://www.w3.org/2000/svg}"


class Charts(unittest.TestCase):
    def saved(self, figure):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "chart.svg"
            plot.save(path, figure)
            return path.read_text()

    def test_a_logarithmic_axis_has_round_ticks_without_exponents(self):
        for values, ticks in (((1, 90), ["1", "2", "5", "10", "20", "50"]), ((2, 90000), ["3", "10", "30", "100", "30,000"]),
                              ((0.001, 1000), ["0.01", "0.1", "1", "100"])):
            figure, (axes,) = plot.panels(("t", "x", "y"))
            axes.loglog(values, values)
            words = [t.text for t in xml.fromstring(self.saved(figure)).iter(f"{SVG}text")]
            self.assertEqual([t for t in ticks if t not in words], [], words)
            self.assertFalse([w for w in words if "e" in w or "^" in w], words)

    def test_a_chart_names_its_series_and_is_the_same_every_time(self):
        def drawn():
            figure, (axes,) = plot.panels(("title", "x", "y"))
            axes.plot([1, 2], [1, 2], label="a & b", **plot.marks(plot.BLUE))
            return self.saved(figure)

        words = [t.text for t in xml.fromstring(drawn()).iter(f"{SVG}text")]
        for word in ("title", "a & b"):
            self.assertIn(word, words)
        self.assertEqual(drawn(), drawn())


class Page(unittest.TestCase):
    def test_blocks_are_renewed_between_their_marks_and_nothing_else(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "page.md"
            path.write_text("before\n<!-- run -->\nold\n<!-- end -->\nbetween\n<!-- fig 3 -->\n<!-- end -->\nafter\n")
            (path.parent / "data/reproduction").mkdir(parents=True)
            figures.renew_page(path, {"run": "new", "fig 3": "second", "fig 11a": "third"})
            self.assertEqual(path.read_text(), "before\n<!-- run -->\n\nnew\n\n<!-- end -->\nbetween\n<!-- fig 3 -->\n\nsecond\n\n"
                                               "<!-- end -->\nafter\n")
            self.assertEqual((path.parent / "data/reproduction/fig11a.txt").read_text(), "third\n")

    def test_the_documentation_has_a_place_for_every_block(self):
        text = (figures.measure.ROOT / "docs" / "reproduction.md").read_text()
        for title in figures.ON_PAGE:
            self.assertEqual(text.count(f"<!-- {title} -->\n"), 1, title)


class TwoSpheres(unittest.TestCase):
    def test_they_are_one_closed_surface_that_faces_out(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "spheres.obj"
            reproduce.two_spheres(path, apart=0.75, segments=48)
            lines = [line.split() for line in path.read_text().splitlines()]
        vertices = [tuple(map(float, line[1:])) for line in lines if line[0] == "v"]
        faces = [tuple(int(i) - 1 for i in line[1:]) for line in lines if line[0] == "f"]
        edges = [(f[i], f[(i + 1) % 3]) for f in faces for i in range(3)]
        self.assertEqual(len(edges), len(set(edges)))
        self.assertEqual(set(edges), {(b, a) for a, b in edges})
        self.assertEqual(len(vertices) - len(edges) // 2 + len(faces), 2)
        for x, y, z in vertices:
            self.assertAlmostEqual(x * x + y * y + (abs(z) - 0.75) ** 2, 1, places=6)
        volume = sum(a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
                     for a, b, c in (tuple(vertices[i] for i in f) for f in faces)) / 6
        # Each sphere without its cap of height 1 - 0.75.
        cap = 3.14159265 * 0.25**2 * (3 - 0.25) / 3
        self.assertAlmostEqual(volume, 2 * (4 * 3.14159265 / 3 - cap), delta=0.06)


if __name__ == "__main__":
    unittest.main()
