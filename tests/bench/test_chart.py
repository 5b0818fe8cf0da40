"""The chart is well-formed and puts points where they belong."""

import math
from xml.etree import ElementTree

import pytest
from chart import HEIGHT, WIDTH, Series, log_log_chart


def circles(text: str) -> list[tuple[float, float]]:
    """Centers of all markers, the legend's last."""
    svg = ElementTree.fromstring(text)
    return [(float(c.get("cx")), float(c.get("cy"))) for c in svg.iter("{http://www.w3.org/2000/svg}circle")]


def test_decades_are_even_and_inside():
    points = [(1e-12, 10.0), (1e-8, 100.0), (1e-4, 1000.0)]
    a, b, c, _legend = circles(log_log_chart("a < b", "x", "y", [Series("line", points)]))
    assert (b[0] - a[0], a[1] - b[1]) == pytest.approx((c[0] - b[0], b[1] - c[1]), abs=0.11)
    assert a[0] < b[0] < c[0] and a[1] > b[1] > c[1]
    assert all(0 < x < WIDTH and 0 < y < HEIGHT for x, y in (a, b, c))


def test_what_has_no_logarithm_is_left_out():
    assert len(circles(log_log_chart("", "x", "y", [Series("a", [(0.0, 1.0), (math.nan, 1.0), (1.0, 2.0)])]))) == 2
    with pytest.raises(ValueError, match="nothing to draw"):
        log_log_chart("", "x", "y", [Series("a", [(0.0, 1.0)])])
