/* See triangle.h. */
#include "light/triangle.h"

#include "base/turn.h"

/* Below this solid angle the area is as good, and rounding as bad. */
static const double SOLID_ANGLE_MIN = 1e-5;
/* A surface seems to face a corner of the triangle by at least this cosine. */
static const double COSINE_MIN = 0.02;

triangle_view triangle_viewed(const vec3 corner[3], vec3 point, double even)
{
  triangle_view view = {.point = point, .even = 1};
  for (int i = 0; i < 3; i++) {
    const vec3 way = v3_sub(corner[i], point);
    view.nearness[i] = 1 / v3_length(way);
    view.seen[i] = v3_scale(way, view.nearness[i]);
  }
  for (int i = 0; i < 3; i++) view.cosine[i] = v3_dot(view.seen[i], view.seen[(i + 1) % 3]);
  view.volume = fabs(v3_dot(view.seen[0], v3_cross(view.seen[1], view.seen[2]))); /* van Oosterom & Strackee 1983 */
  view.solid_angle = 2 * atan2(view.volume, 1 + view.cosine[0] + view.cosine[1] + view.cosine[2]);
  view.area = v3_scale(v3_cross(v3_sub(corner[1], corner[0]), v3_sub(corner[2], corner[0])), 0.5);
  if (view.solid_angle > SOLID_ANGLE_MIN && v3_dot(view.area, view.area) > 0) view.even = even;
  return view;
}

double triangle_density(const triangle_view *view, vec3 place)
{
  if (view->even >= 1) return 1;
  const vec3 way = v3_sub(place, view->point);
  const double length2 = v3_dot(way, way);
  const double seen = fabs(v3_dot(way, view->area)) / (view->solid_angle * length2 * sqrt(length2));
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

/* The place below which a part u of the solid angle lies on one side, and which is nearer to the second corner the smaller v
 * is (Arvo 1995, "Stratified sampling of spherical triangles"). Its direction is a sum of the directions to the corners, so
 * that scalars are all it takes. */
static void place_seen(const triangle_view *view, double u, double v, double barycentric[2])
{
  const double ab = view->cosine[0], bc = view->cosine[1], ca = view->cosine[2];
  /* at corner a: cosine and sine of the angle, both times the sines of the sides that meet there */
  const double cos_a = bc - ab * ca, sin_a = view->volume, sines2 = cos_a * cos_a + sin_a * sin_a;
  double sin_part, cos_part;
  turn_sincos(u * view->solid_angle * (0.5 / M_PI), &sin_part, &cos_part);
  const double s = sin_part * cos_a - cos_part * sin_a, t = cos_part * cos_a + sin_part * sin_a;
  const double p = t - cos_a, q = s + sin_a * ab;
  const double cos_c = min2(max2(((q * t - p * s) * cos_a - q * sines2) / ((q * s + p * t) * sin_a), ca), 1);
  /* the point on the side from a to c, and the one on the arc from it to b */
  const double c = sqrt((1 - cos_c * cos_c) / (1 - ca * ca)), a = cos_c - c * ca, split_b = a * ab + c * bc;
  const double cos_b = 1 - v * (1 - split_b), w = sqrt((1 - cos_b * cos_b) / (1 - split_b * split_b));
  const double share[3] = {w * a * view->nearness[0], (cos_b - w * split_b) * view->nearness[1],
                           w * c * view->nearness[2]};
  const double scale = 1 / (share[0] + share[1] + share[2]);
  for (int i = 0; i < 2; i++) barycentric[i] = saturate(share[i + 1] * scale);
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
  place_seen(view, u, v, barycentric);
}
