"""Searches, what is kept from one comparison to the next, means, and whole runs of all peers on a small surface."""

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy
from affine import Affine

import programs
import report
from cache import Cache
from comparison import Comparison
from dem import Dem
from evaluate import Measures
from programs import PYDELATIN, Program, Run, peers
from search import PRECISION, coarsest

ASKED = 4.0
EXACT = Measures(10, 1.0, 2.0, 0.5, uncovered=0, overturned=0, area=1.0)


def hills() -> Dem:
    """21 × 30 samples, 10 m apart, up to 20 m high."""
    row, column = numpy.indices((21, 30))
    heights = numpy.round(10 * numpy.sin(column / 3) + 10 * numpy.cos(row / 4), 1)
    return Dem("hills", Path("hills.tif"), heights, Affine.identity(), (10.0, 10.0))


def row(
    program="pydelatin", asked=10.0, triangles=10, pydelatin=20, samples=1000, seconds=2.0, kept=True
) -> report.Row:
    run = Run(replace(EXACT, triangles=triangles), seconds, None, 50.0, asked)
    return report.Row("dem", "100 × 10", samples, False, program, asked, run, pydelatin, kept)


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)


class Searches(unittest.TestCase):
    def test_the_coarsest_setting_is_found_from_either_side(self):
        fewest = coarsest(lambda count: count, lambda count: count >= 700, fine=10_000, coarse=16)
        self.assertTrue(700 <= fewest <= 700 * PRECISION, fewest)
        largest = coarsest(lambda error: error, lambda error: error <= 7, fine=0.1, coarse=40)
        self.assertTrue(7 / PRECISION <= largest <= 7, largest)

    def test_the_finest_setting_is_tried_last(self):
        self.assertEqual(coarsest(lambda count: count, lambda count: count >= 10_000, fine=10_000, coarse=16), 10_000)
        self.assertIsNone(coarsest(lambda count: count, lambda _: False, fine=10_000, coarse=16))


class Promises(unittest.TestCase):
    def test_an_error_is_held_where_it_is_promised(self):
        at_samples = Program("a", run=lambda *_: None)
        everywhere = Program("b", run=lambda *_: None, is_bounded_everywhere=True)
        self.assertTrue(at_samples.keeps(EXACT, 1.0))
        self.assertFalse(at_samples.keeps(EXACT, 0.9999))
        self.assertFalse(everywhere.keeps(EXACT, 1.0))
        self.assertTrue(everywhere.keeps(EXACT, 2.0))
        self.assertFalse(at_samples.keeps(replace(EXACT, uncovered=1), 1.0))

    def test_martini_gets_the_largest_square_of_a_power_of_two_and_one(self):
        for smaller, side in [(21, 17), (17, 17), (16, 9), (1201, 1025), (1025, 1025), (2, 2)]:
            surface = replace(hills(), heights=numpy.zeros((smaller, smaller + 5)))
            self.assertEqual(programs.martini_side(surface), side)


class Kept(Folder):
    def test_a_peer_runs_once_and_again_when_fresh_and_ours_always(self):
        runs = []

        def run(*_):
            runs.append(1)
            return Run(EXACT, 1.0, None, 50.0, ASKED)

        for is_fresh, is_cached, expected in [(False, True, 1), (False, True, 1), (True, True, 2), (False, False, 4)]:
            cache = Cache(self.folder, is_fresh)
            for _ in range(2):
                found = cache.run(Program("peer", run, is_cached=is_cached), hills(), ASKED, run)
            self.assertEqual((len(runs), found.measures), (expected, EXACT))

    def test_that_no_setting_gives_the_error_is_found_out_once(self):
        runs = []

        def run():
            runs.append(1)
            return programs.found(lambda _: Run(EXACT, 1.0, None, 50.0, ASKED), error=0.5, fine=1.0, coarse=1.01)

        for _ in range(2):
            with self.assertRaisesRegex(programs.NoSetting, "an error of 0.5 m"):
                Cache(self.folder, is_fresh=False).run(Program("peer", run), hills(), 0.5, run)
        self.assertEqual(len(runs), 1)

    def test_other_heights_another_error_and_another_cell_are_other_runs(self):
        cache = Cache(self.folder, is_fresh=False)
        peer = Program("peer", run=lambda *_: None)
        other_cell = replace(hills(), cell=(10.0, 20.0))
        for dem, error in [(hills(), 1.0), (hills(), 2.0), (other_cell, 1.0), (hills().first_square(5), 1.0)]:
            cache.run(peer, dem, error, lambda: Run(EXACT, 1.0, None, 50.0, ASKED))
        self.assertEqual(len(list(self.folder.iterdir())), 4)


class Tables(unittest.TestCase):
    def test_the_summary_has_the_geometric_mean_and_seconds_by_samples(self):
        rows = [
            row(triangles=20, pydelatin=80, samples=1_000_000, seconds=1.0),
            row(triangles=100, pydelatin=100, samples=3_000_000, seconds=5.0, kept=False),
        ]
        line = report.summary_table(rows).splitlines()[-1]
        self.assertEqual(line, "| pydelatin | 2 | 1 of 2 | 0.500 | 1.000 | 0.500 | 1.50 |")

    def test_an_error_at_which_a_program_gave_nothing_is_a_dash(self):
        rows = [row("a", asked=5.0), row("b", asked=5.0), row("b", asked=20.0)]
        self.assertTrue(report.summary_table(rows).splitlines()[2].endswith("| – | – |"))

    def test_flaws_stand_in_the_table(self):
        torn = row(kept=False)
        torn = replace(torn, run=replace(torn.run, measures=replace(EXACT, uncovered=3)))
        self.assertIn("no, 3 samples uncovered", report.dem_table([torn]))


class Peers(Folder):
    def test_every_peer_gives_a_whole_surface_as_near_as_was_asked(self):
        comparison = Comparison(peers(), Cache(self.folder / "cache", is_fresh=False), self.folder)
        rows = {row.program: row for row in comparison.run(hills(), [ASKED])}
        self.assertEqual(comparison.failures, [])
        self.assertEqual(list(rows), [program.name for program in peers()])
        for name in ("pydelatin", "pymartini", "fast-simplification, searched", "pyfqmr, searched"):
            self.assertTrue(rows[name].kept, rows[name])
            self.assertLess(rows[name].run.measures.triangles, 2 * 20 * 29)
        self.assertLessEqual(rows["meshoptimizer, searched"].run.measures.max_at_samples, ASKED)
        self.assertEqual(rows["pymartini"].size, "17 × 17")

    def test_cost_is_that_of_the_program_alone(self):
        burden = numpy.ones(60_000_000)
        run = PYDELATIN.run(hills(), ASKED, self.folder)
        self.assertLess(run.peak_megabytes, burden.nbytes / 1e6 / 2)
        self.assertTrue(0 < run.algorithm_seconds < run.cpu_seconds < 5, run)

    def test_a_program_that_fails_is_named_and_not_counted(self):
        ours = programs.terrain_ingest(Path("/bin/false"), "default", "samples")
        comparison = Comparison([ours], Cache(self.folder / "cache", is_fresh=False), self.folder)
        self.assertEqual(comparison.run(hills(), [ASKED]), [])
        self.assertEqual([failure.program for failure in comparison.failures], ["terrain-ingest default, samples"])


if __name__ == "__main__":
    unittest.main()
