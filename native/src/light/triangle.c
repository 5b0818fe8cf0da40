/* See triangle.h. */
#include "light/triangle.h"

/* Below this solid angle the area is as good, and rounding as bad. */
static const double SOLID_ANGLE_MIN = 1e-5;
/* A surface seems to face a corner of the triangle by at least this cosine. */
static const double COSINE_MIN = 0.02;

triangle_view triangle_viewed(const vec3 corner[3], vec3 point, double even)
{
  triangle_view view = {.corner = {corner[0], corner[1], corner[2]}, .point = point, .even = 1};
  for (int i = 0; i < 3; i++) view.seen[i] = v3_normalize(v3_sub(corner[i], point));
  const vec3 a = view.seen[0], b = view.seen[1], c = view.seen[2];
  const double volume = fabs(v3_dot(a, v3_cross(b, c))); /* van Oosterom & Strackee 1983 */
  view.solid_angle = 2 * atan2(volume, 1 + v3_dot(a, b) + v3_dot(b, c) + v3_dot(c, a));
  if (!(view.solid_angle > SOLID_ANGLE_MIN)) return view;
  const vec3 area = v3_scale(v3_cross(v3_sub(corner[1], corner[0]), v3_sub(corner[2], corner[0])), 0.5);
  const double size = v3_length(area);
  if (!(size > 0)) return view;
  view.normal = v3_scale(area, 1 / size);
  view.area_over = size / view.solid_angle;
  view.even = even;
  return view;
}

double triangle_density(const triangle_view *view, vec3 place)
{
  if (view->even >= 1) return 1;
  const vec3 way = v3_sub(place, view->point);
  const double length2 = v3_dot(way, way);
  const double seen = fabs(v3_dot(way, view->normal)) * view->area_over / (length2 * sqrt(length2));
  return view->even + (1 - view->even) * seen;
}

/* Draws x in [0, 1] as often as (1 - x) a + x b, by the even number u. */
static double draw_linear(double a, double b, double u)
{
  return u * (a + b) / (a + sqrt((1 - u) * a * a + u * b * b));
}

/* Turns even numbers into such as let the corners be seen as often as `normal` faces them; returns how much more often
 * than on average the result is drawn. The square (u, v) is the triangle: v = 0 its second corner, u the side between the
 * others. */
static double face(const triangle_view *view, vec3 normal, double *u, double *v)
{
  double cosine[3];
  for (int i = 0; i < 3; i++) cosine[i] = max2(v3_dot(normal, view->seen[i]), COSINE_MIN);
  const double near = cosine[1], far = (cosine[0] + cosine[2]) / 2;
  *v = draw_linear(near, far, *v);
  const double low = (1 - *v) * near + *v * cosine[0], high = (1 - *v) * near + *v * cosine[2];
  *u = draw_linear(low, high, *u);
  return 2 * ((1 - *u) * low + *u * high) / (near + far);
}

/* The part of b at right angles to the unit vector a, as a unit vector. */
static vec3 beside(vec3 b, vec3 a) { return v3_normalize(v3_mad(a, -v3_dot(a, b), b)); }

/* The direction in which a part u of the solid angle lies on one side, and v of it nearer to the second corner (Arvo 1995,
 * "Stratified sampling of spherical triangles"). */
static vec3 direction_in(const triangle_view *view, double u, double v)
{
  const vec3 a = view->seen[0], b = view->seen[1], c = view->seen[2];
  const vec3 ab = v3_normalize(v3_cross(a, b)), ac = v3_normalize(v3_cross(a, c));
  const double cos_a = v3_dot(ab, ac), sin_a = v3_length(v3_cross(ab, ac));
  const double part = u * view->solid_angle, cos_part = cos(part), sin_part = sin(part);
  const double s = sin_part * cos_a - cos_part * sin_a, t = cos_part * cos_a + sin_part * sin_a;
  const double p = t - cos_a, q = s + sin_a * v3_dot(a, b);
  const double below = (q * s + p * t) * sin_a, wanted = ((q * t - p * s) * cos_a - q) / below;
  const double cos_c = below != 0 ? min2(max2(wanted, -1), 1) : v3_dot(a, c);
  const vec3 split = v3_mad(beside(c, a), sqrt(1 - cos_c * cos_c), v3_scale(a, cos_c));
  const double cos_b = 1 - v * (1 - v3_dot(split, b));
  return v3_mad(beside(split, b), sqrt(max2(1 - cos_b * cos_b, 0)), v3_scale(b, cos_b));
}

/* Where the plane is met, clamped into the triangle. */
static void meet(const triangle_view *view, vec3 direction, double barycentric[2])
{
  const vec3 edge1 = v3_sub(view->corner[1], view->corner[0]), edge2 = v3_sub(view->corner[2], view->corner[0]);
  const vec3 way = v3_sub(view->point, view->corner[0]), h = v3_cross(direction, edge2), k = v3_cross(way, edge1);
  const double scale = 1 / v3_dot(edge1, h);
  const double x = saturate(v3_dot(way, h) * scale), y = saturate(v3_dot(direction, k) * scale);
  const double over = max2(x + y, 1);
  barycentric[0] = x / over, barycentric[1] = y / over;
}

void triangle_draw(const triangle_view *view, vec3 normal, double u, double v, double barycentric[2], double *facing)
{
  *facing = 1;
  if (v < view->even) {
    const double root = sqrt(u), along = v / view->even; /* even over the area (Turk 1990) */
    barycentric[0] = root * (1 - along), barycentric[1] = root * along;
    return;
  }
  v = (v - view->even) / (1 - view->even);
  if (v3_dot(normal, normal) > 0) *facing = face(view, normal, &u, &v);
  meet(view, direction_in(view, u, v), barycentric);
}
