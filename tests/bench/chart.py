"""A chart with two logarithmic axes as SVG text, so that the bench needs no plotting library."""

import math
from dataclasses import dataclass, field
from xml.sax.saxutils import escape

COLORS = ("#4053d3", "#ddb310", "#b51d14", "#00beff", "#fb49b0", "#00b25d", "#7a7a7a", "#8c5a2b", "#222222")
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 860, 520, 74, 250, 44, 58


@dataclass
class Series:
    """A named line through points, or a cloud of hollow ones."""

    name: str
    points: list[tuple[float, float]] = field(default_factory=list)
    is_cloud: bool = False


class LogAxis:
    """Maps positive values to a range of pixels, decades evenly."""

    def __init__(self, values: list[float], first: float, last: float) -> None:
        self.low = math.floor(math.log10(min(values)))
        self.high = max(self.low + 1, math.ceil(math.log10(max(values))))
        self.first, self.last = first, last

    def __call__(self, value: float) -> float:
        """Pixels."""
        return self.first + (math.log10(value) - self.low) / (self.high - self.low) * (self.last - self.first)

    def decades(self) -> list[int]:
        """Powers of ten to label: at most ten of them."""
        return list(range(self.low, self.high + 1, max(1, math.ceil((self.high - self.low) / 10))))


def log_log_chart(title: str, x_label: str, y_label: str, series: list[Series]) -> str:
    """The chart as an SVG file's text. Points with a coordinate that is not positive are left out."""
    drawn = [
        Series(s.name, [p for p in s.points if min(p) > 0 and all(map(math.isfinite, p))], s.is_cloud) for s in series
    ]
    drawn = [s for s in drawn if s.points]
    if not drawn:
        raise ValueError("nothing to draw: no series has a positive point")
    x = LogAxis([p[0] for s in drawn for p in s.points], LEFT, WIDTH - RIGHT)
    y = LogAxis([p[1] for s in drawn for p in s.points], HEIGHT - BOTTOM, TOP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif"',
        ' font-size="13">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
        f'<text x="{LEFT}" y="26" font-size="17">{escape(title)}</text>',
        f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 14}" text-anchor="middle">{escape(x_label)}</text>',
        f'<text transform="translate(18 {HEIGHT / 2}) rotate(-90)" text-anchor="middle">{escape(y_label)}</text>',
    ]
    parts += grid(x, y)
    for index, line in enumerate(drawn):
        parts += draw(line, COLORS[index % len(COLORS)], x, y, TOP + 12 + 21 * index)
    return "\n".join([*parts, "</svg>\n"])


def grid(x: LogAxis, y: LogAxis) -> list[str]:
    """Lines and labels at powers of ten."""
    parts = []
    for k in x.decades():
        at = x(10.0**k)
        parts.append(f'<path d="M{at:.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#ddd"/>')
        parts.append(f'<text x="{at:.1f}" y="{HEIGHT - BOTTOM + 18}" text-anchor="middle">{power(k)}</text>')
    for k in y.decades():
        at = y(10.0**k)
        parts.append(f'<path d="M{LEFT} {at:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>')
        parts.append(f'<text x="{LEFT - 8}" y="{at + 4:.1f}" text-anchor="end">{power(k)}</text>')
    return parts


def power(k: int) -> str:
    """10^k, small powers written out."""
    if -1 <= k <= 4:
        return f"{10.0**k:g}"
    return f'10<tspan dy="-5" font-size="10">{k}</tspan>'


def draw(line: Series, color: str, x: LogAxis, y: LogAxis, legend_y: float) -> list[str]:
    """One line with its markers, and its entry in the legend."""
    fill = "white" if line.is_cloud else color
    path = " ".join(f"{x(a):.1f},{y(b):.1f}" for a, b in sorted(line.points))
    legend_x = WIDTH - RIGHT + 22
    stroke = f'stroke="{color}" stroke-width="1.6"'
    marker = f'r="4" fill="{fill}" {stroke}'
    lines = [
        f'<polyline points="{path}" fill="none" {stroke}/>',
        f'<path d="M{legend_x - 10} {legend_y}h20" {stroke}/>',
    ]
    return [
        *([] if line.is_cloud else lines),
        *(f'<circle cx="{x(a):.1f}" cy="{y(b):.1f}" {marker}/>' for a, b in line.points),
        f'<circle cx="{legend_x}" cy="{legend_y}" {marker}/>',
        f'<text x="{legend_x + 18}" y="{legend_y + 4}">{escape(line.name)}</text>',
    ]
