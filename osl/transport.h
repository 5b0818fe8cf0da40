/* Light rays through curved space by integration, in float32: Kerr (Schwarzschild among it) and Ellis. For OSL only.
 *
 * In Mino time the equations are separate: x = 1/r (Ellis: atan(1/l), which keeps its digits far away on either side)
 * obeys x'' = f(x), the unit vector n obeys n'' = g(n), and a Kerr hole turns all about its axis by an angle whose rate
 * depends on x alone. No velocity appears on the right: that is the case of Nystroem's methods. His of order 5 takes four
 * stages a step (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.14).
 *
 * Lengths are in units of the mass or of the throat's radius. `a` is the spin; a ray followed backward in time sees s = -a.
 * "Chart" is how curved space is drawn into the scene: CHART_ISOTROPIC without spin, CHART_OBLATE, CHART_WORMHOLE.
 */
#ifndef BENT_OSL_TRANSPORT_H
#define BENT_OSL_TRANSPORT_H

#define CHART_ISOTROPIC 0
#define CHART_OBLATE 1
#define CHART_WORMHOLE 2

#define FATE_LOST 0 /* captured, or so close to the critical ray that float32 cannot tell */
#define FATE_NEAR 1 /* leaves where it came in */
#define FATE_FAR 2  /* leaves by the other mouth */
#define FATE_INSIDE 3 /* goes on */

/* Radians, roughly, that a ray turns by in one step; measured: README, "Measured". */
#define STEP 0.25
#define STEPS_MAX 200

struct Space {
  int chart;
  float a;          /* spin over mass */
  float radius;     /* of the sphere where the ray leaves, in the chart */
  float far_radius; /* of the sphere around the other mouth */
};

struct Ray {
  int side;    /* -1: beyond a wormhole's throat, where x and v count from the other end */
  float x, v;  /* 0 at infinity, pi/2 at a throat; and its rate */
  vector n, m; /* angular position without drag, and its rate */
  float drag;  /* angle */
  float E, L, Q;
};

/* A wormhole's x at l = R - 1/(4R). OSL's own atan is off by up to 1e-5; its sine and cosine are not. */
float angle_wormhole(float R)
{
  float l = R - 0.25 / R, x = atan2(1, l);
  return x - (l * sin(x) - cos(x)) / (l * cos(x) + sin(x));
}

/* Radius r where the oblate chart has the point p. */
float radius_oblate(point p, float a)
{
  float b = dot(p, p) - a * a;
  return sqrt(0.5 * (b + hypot(b, 2 * a * p[2])));
}

vector east_of(vector n)
{
  float sine = hypot(n[0], n[1]);
  return sine > 1e-6 ? vector(-n[1], n[0], 0) / sine : vector(0, 1, 0);
}

/* Outward in the chart at angular position n: the oblate spheroid's normal. */
vector outward_of(vector n, float r, float a)
{
  return normalize(vector(r * n[0], r * n[1], hypot(r, a) * n[2]));
}

/* Sigma, Delta and A of the Kerr metric. */
void kerr_functions(float r, vector n, float a, output float sigma, output float delta, output float area)
{
  float square = r * r + a * a;
  sigma = r * r + a * a * n[2] * n[2];
  delta = square - 2 * r;
  area = square * square - a * a * delta * (n[0] * n[0] + n[1] * n[1]);
}

/* A ray that starts at p in the local unit direction d. Returns 0 inside the horizon or throat. */
int launch(Space space, point p, vector d, output Ray ray)
{
  ray.side = 1;
  if (space.chart == CHART_WORMHOLE) {
    float R = length(p), r = R + 0.25 / R;
    ray.n = p / R;
    ray.v = -dot(d, ray.n);
    ray.m = r * (d + ray.v * ray.n);
    ray.x = angle_wormhole(R);
    ray.drag = 0, ray.E = 1, ray.L = 0;
    ray.Q = dot(ray.m, ray.m);
    return R > 0.5;
  }
  float a = space.a, s = -a, r, sigma, delta, area;
  if (space.chart == CHART_ISOTROPIC) {
    float R = length(p), one = 1 + 0.5 / R;
    r = R * one * one;
    ray.n = p / R;
    if (R <= 0.5) return 0;
  } else {
    r = radius_oblate(p, a);
    float h = hypot(r, a);
    ray.n = normalize(vector(p[0] / h, p[1] / h, p[2] / r));
  }
  kerr_functions(r, ray.n, a, sigma, delta, area);
  vector east = east_of(ray.n), outward = outward_of(ray.n, r, a);
  float south_rate = sqrt(sigma) * dot(d, cross(east, outward));
  float east_rate = sqrt(area / sigma) * dot(d, east);
  ray.L = hypot(ray.n[0], ray.n[1]) * east_rate;
  ray.E = sqrt(max(sigma * delta / area, 0)) + 2 * s * r / area * ray.L;
  ray.Q = south_rate * south_rate + ray.n[2] * ray.n[2] * (east_rate * east_rate - s * s * ray.E * ray.E);
  ray.x = 1 / r;
  ray.v = -sqrt(max(sigma * delta, 0)) * dot(d, outward) * ray.x * ray.x;
  ray.m = south_rate * cross(east, ray.n) + east_rate * east;
  ray.drag = 0;
  return delta > 0 && r > 1;
}

/* Right-hand sides. */
float acceleration(Space space, Ray ray, float x)
{
  if (space.chart == CHART_WORMHOLE) return -0.5 * ray.Q * sin(2 * x);
  float s = -space.a, apart = ray.L - s * ray.E;
  float K = apart * apart + ray.Q;
  return x * (s * s * ray.E * ray.E - ray.L * ray.L - ray.Q + x * (3 * K - 2 * s * s * ray.Q * x));
}

vector turning(Space space, Ray ray, vector n)
{
  float spin = space.a * space.a * ray.E * ray.E;
  return vector(0, 0, spin * n[2]) - (ray.Q + ray.L * ray.L + 2 * spin * n[2] * n[2]) * n;
}

float drag_rate(Space space, Ray ray, float w)
{
  float s = -space.a;
  return s * w * (2 * ray.E - s * ray.L * w) / (1 - 2 * w + s * s * w * w);
}

/* The ray after Mino time h. */
Ray advanced(Space space, Ray ray, float h)
{
  float hh = h * h;
  float x1 = acceleration(space, ray, ray.x);
  vector n1 = turning(space, ray, ray.n);
  float at2 = ray.x + h / 5 * ray.v + hh / 50 * x1;
  float x2 = acceleration(space, ray, at2);
  vector n2 = turning(space, ray, ray.n + h / 5 * ray.m + hh / 50 * n1);
  float at3 = ray.x + 2 * h / 3 * ray.v + hh / 27 * (7 * x2 - x1);
  float x3 = acceleration(space, ray, at3);
  vector n3 = turning(space, ray, ray.n + 2 * h / 3 * ray.m + hh / 27 * (7 * n2 - n1));
  float at4 = ray.x + h * ray.v + hh / 70 * (21 * x1 - 4 * x2 + 18 * x3);
  float x4 = acceleration(space, ray, at4);
  vector n4 = turning(space, ray, ray.n + h * ray.m + hh / 70 * (21 * n1 - 4 * n2 + 18 * n3));
  Ray next = ray;
  next.x = ray.x + h * ray.v + hh / 336 * (14 * x1 + 100 * x2 + 54 * x3);
  next.n = ray.n + h * ray.m + hh / 336 * (14 * n1 + 100 * n2 + 54 * n3);
  next.v = ray.v + h / 336 * (14 * x1 + 125 * x2 + 162 * x3 + 35 * x4);
  next.m = ray.m + h / 336 * (14 * n1 + 125 * n2 + 162 * n3 + 35 * n4);
  if (space.a != 0)
    next.drag += h / 336 * (14 * drag_rate(space, ray, ray.x) + 125 * drag_rate(space, ray, at2) +
                            162 * drag_rate(space, ray, at3) + 35 * drag_rate(space, ray, at4));
  if (space.chart == CHART_WORMHOLE && next.x > M_PI_2) next.side = -ray.side, next.x = M_PI - next.x, next.v = -next.v;
  return next;
}

float step_of(Space space, Ray ray)
{
  float spin = space.a * ray.E;
  float rate = sqrt(max(ray.Q + ray.L * ray.L, 0) + spin * spin) + abs(ray.v);
  if (space.a != 0) rate += abs(drag_rate(space, ray, ray.x));
  return STEP / rate;
}

/* Radius of the sphere that a ray would leave by, in the chart. */
float edge_of(Space space, Ray ray) { return ray.side > 0 ? space.radius : space.far_radius; }

/* Negative outside the sphere; and its rate. */
void depth_of(Space space, Ray ray, output float depth, output float rate)
{
  float R = edge_of(space, ray), a = space.a;
  float r = 1 / angle_wormhole(R);
  if (space.chart == CHART_ISOTROPIC) r = R * (1 + 0.5 / R) * (1 + 0.5 / R);
  else if (space.chart == CHART_OBLATE) r = sqrt(R * R - a * a * (1 - ray.n[2] * ray.n[2]));
  depth = ray.x * r - 1;
  rate = ray.v * r + ray.x * a * a * ray.n[2] * ray.m[2] / r;
}

/* Point and local direction of a ray in the chart. */
void placed(Space space, Ray ray, output point p, output vector d)
{
  vector n = normalize(ray.n), m = ray.m - dot(ray.m, n) * n;
  if (space.chart == CHART_WORMHOLE) {
    float R = edge_of(space, ray);
    vector mirror = vector(1, ray.side, 1); /* or the world beyond would look mirrored */
    p = R * n * mirror;
    d = normalize((m / (R + 0.25 / R) - ray.v * n) * mirror);
    return;
  }
  float r = 1 / ray.x, a = space.a, sigma, delta, area;
  kerr_functions(r, n, a, sigma, delta, area);
  n = rotate(n, ray.drag, point(0), point(0, 0, 1));
  m = rotate(m, ray.drag, point(0), point(0, 0, 1));
  vector east = east_of(n), outward = outward_of(n, r, a);
  float up = -ray.v * r * r / sqrt(sigma * delta);
  d = normalize(up * outward + dot(m, cross(east, n)) / sqrt(sigma) * cross(east, outward) +
                dot(m, east) * sqrt(sigma / area) * east);
  float h = hypot(r, a);
  p = space.chart == CHART_ISOTROPIC ? point(space.radius * n) : point(h * n[0], h * n[1], r * n[2]);
}

/* Goes back from `next`, which lies outside, to the sphere itself: Newton's method, from outside, where depth is concave. */
Ray landed(Space space, Ray ray, Ray next, float h)
{
  Ray end = next;
  float step = h, depth, rate;
  for (int i = 0; i < 12; i++) {
    depth_of(space, end, depth, rate);
    if (abs(depth) < 2e-7 || rate >= 0) return end;
    step -= depth / rate;
    end = advanced(space, ray, step);
  }
  return end;
}

/* One step: the ray's fate, where it then is, and the Mino time of a step that stays inside. */
int stepped(Space space, Ray ray, output Ray next, output float h)
{
  float depth, rate;
  h = step_of(space, ray);
  next = advanced(space, ray, h);
  depth_of(space, next, depth, rate);
  if (depth < 0 && rate < 0) {
    next = landed(space, ray, next, h);
    return next.side > 0 ? FATE_NEAR : FATE_FAR;
  }
  float horizon = 1 / (1 + sqrt(1 - space.a * space.a));
  return space.chart != CHART_WORMHOLE && next.x >= horizon ? FATE_LOST : FATE_INSIDE;
}

/* Whether a ray is past return: it goes inward, and nothing slows it on its way to the horizon. Its acceleration over x is
 * quadratic in x, and concave or growing (Q above or below 0): both ends tell. Steps shrink toward the horizon, around which
 * a spinning hole drags light without end, so that the rest of the way would take many. */
int is_captured(Space space, Ray ray)
{
  float horizon = 1 / (1 + sqrt(1 - space.a * space.a));
  return space.chart != CHART_WORMHOLE && ray.v > 0 && acceleration(space, ray, ray.x) > 0 &&
         acceleration(space, ray, horizon) > 0;
}

/* From inside the sphere or from its surface to where the ray leaves: fate, point and local direction. */
int follow(Space space, point start, vector direction, output point p, output vector d)
{
  Ray ray, next;
  if (!launch(space, start, direction, ray)) return FATE_LOST;
  for (int i = 0; i < STEPS_MAX; i++) {
    float h;
    int fate = stepped(space, ray, next, h);
    if (fate != FATE_INSIDE) {
      if (fate != FATE_LOST) placed(space, next, p, d);
      return fate;
    }
    if (is_captured(space, next)) return FATE_LOST;
    ray = next;
  }
  return FATE_LOST;
}
#endif
