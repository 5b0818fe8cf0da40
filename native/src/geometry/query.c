/* One Embree query along a straight piece of a ray.
 *
 * A ray that leaves a surface must not meet it again at length 0, nor slip through a neighbor. In float32 Embree sees the
 * start off by up to a bound of its rounding: above the surface or below it, or beyond a neighbor. So the query starts
 * farther than that above the source triangle, on the side to which the ray leaves, and inside its edges by ever so much
 * more: enough to stay on the ray's side of neighbors that bend towards it, down to wedges of ABOVE / INSIDE = 3.6 degrees.
 * What the ray meets then is off by a few roundings, as Embree's own answers are. Of triangles that lie behind this start
 * Embree may still report those in whose plane it nearly is, wide ones above all: double precision finds them out.
 */
#include "geometry/query.h"

/* Hits passed over before giving up. */
enum { ATTEMPTS = 16 };

/* How far the query's start is moved off the source's plane, and away from its edges, in bounds of rounding. */
static const double ABOVE = 2, INSIDE = 32;
/* Embree's test of a triangle of size 1 from a point in its plane is off by no more. */
static const double TRIANGLE_ROUNDING = 8 * 0x1p-24;

/* The point of the source triangle, whose first two edges are no longer than `size`, nearest to `origin` that keeps
 * INSIDE * rounding from its edges. */
static vec3 pull_inside(const triangle *t, double size, vec3 origin, double rounding)
{
  double b[3], margin[3], excess = 0;
  triangle_barycentric(t, origin, &b[1]);
  b[0] = 1 - b[1] - b[2];
  const double area = v3_length(t->normal); /* twice the triangle's; divided by an edge it is the height above it */
  if (min2(b[0], min2(b[1], b[2])) * area >= INSIDE * rounding * 2 * size) return origin;
  const double opposite[3] = {v3_length(v3_sub(t->edge2, t->edge1)), v3_length(t->edge2), v3_length(t->edge1)};
  int moved = 0;
  for (int i = 0; i < 3; i++) {
    margin[i] = fmin(INSIDE * rounding * opposite[i] / area, 1.0 / 3);
    if (b[i] < margin[i]) b[i] = margin[i], moved = 1;
    excess += b[i] - margin[i];
  }
  if (!moved) return origin;
  const double spare = 1 - margin[0] - margin[1] - margin[2];
  for (int i = 0; i < 3; i++) b[i] = margin[i] + (excess > 0 ? (b[i] - margin[i]) * spare / excess : 0);
  return triangle_point(t, &b[1]);
}

/* Where the query of a leaving ray starts. */
static vec3 leave(const geometry *g, const query *q)
{
  const bent_ray *ray = q->leaving;
  const instance *i = &g->instances[ray->source_instance];
  const triangle t = triangle_of(g, ray->source_instance, ray->source_triangle);
  const double area = v3_length(t.normal);
  if (!(area > 0)) return q->start;
  const vec3 seen = v3_sub(q->start, g->origin);
  const double coordinate = max2(fabs(seen.x), max2(fabs(seen.y), fabs(seen.z)));
  const double size = sqrt(max2(v3_dot(t.edge1, t.edge1), v3_dot(t.edge2, t.edge2)));
  const double rounding = i->float_error_offset + i->float_error_scale * coordinate + TRIANGLE_ROUNDING * size;
  const double side = v3_dot(t.normal, q->departure) < 0 ? -1 : 1;
  return v3_mad(t.normal, side * ABOVE * rounding / area, pull_inside(&t, size, q->start, rounding));
}

/* The query's ray in double precision. */
typedef struct line {
  vec3 start, span;
} line;

/* A moved start keeps the end where it is: what goes on from there must not find a gap. */
static line line_of(const geometry *g, const query *q)
{
  line l = {q->start, q->span};
  if (!q->leaving) return l;
  l.start = leave(g, q);
  if (q->far > 0 && isfinite(q->far)) l.span = v3_mad(v3_sub(q->start, l.start), 1 / q->far, q->span);
  return l;
}

/* Whether the triangle cannot be met by the line of a leaving ray. */
static int is_passed_over(const geometry *g, const query *q, const line *l, const found *f)
{
  if (!q->leaving) return 0;
  if (f->instance == q->leaving->source_instance && f->triangle == q->leaving->source_triangle) return 1;
  const triangle t = triangle_of(g, f->instance, f->triangle);
  return v3_dot(t.normal, v3_sub(t.v0, l->start)) * v3_dot(t.normal, l->span) < 0;
}

int geometry_query(const geometry *g, const query *q, found *out)
{
  const embree_table *e = embree();
  const line l = line_of(g, q);
  const double early = max2(-q->near, 0);
  const vec3 start = v3_mad(l.span, -early, l.start);
  const instance *i = q->inside;
  const vec3 origin = i ? mat4_point(&i->mesh_from_world, start) : v3_sub(start, g->origin);
  const vec3 span = i ? mat4_vector(&i->mesh_from_world, l.span) : l.span;
  float from = q->near > 0 ? (float)q->near : 0;
  for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
    embree_ray ray = {.origin = {(float)origin.x, (float)origin.y, (float)origin.z},
                      .near = from,
                      .direction = {(float)span.x, (float)span.y, (float)span.z},
                      .far = (float)(q->far + early),
                      .mask = q->visibility,
                      .geometry = EMBREE_INVALID,
                      .instance = EMBREE_INVALID};
    e->intersect1(i ? g->meshes[i->mesh].scene : g->top, &ray, NULL);
    if (ray.geometry == EMBREE_INVALID) return 0;
    *out = (found){.instance = i ? (int)(i - g->instances) : (int)ray.instance, .triangle = (int)ray.triangle, .at = ray.far - early,
                   .b = {ray.u, ray.v}};
    if (!is_passed_over(g, q, &l, out)) return 1;
    from = nextafterf(ray.far, INFINITY);
  }
  return 0;
}
