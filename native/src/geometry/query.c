/* One Embree query along a straight piece of a ray.
 *
 * A ray that leaves a surface must not meet it again at length 0. The plane of the triangle that it leaves is not met
 * again within the piece (the caller sees to that), so this triangle is passed over by its number. Its neighbors lie
 * within rounding of the start: for Embree, in float32, the start may be on the wrong side of them. So the query starts a
 * little early and a little inside the triangle, by a bound of Embree's rounding, and hits that near are put to double
 * precision: is the triangle met, and ahead of the start?
 */
#include "geometry/query.h"

/* Hits passed over before giving up; only surfaces that coincide with the source to rounding are passed over. */
enum { ATTEMPTS = 16 };

/* How far the query's start is moved along the ray, and away from the source's edges, in bounds of rounding. */
static const double EARLY = 4, INSIDE = 8;

/* What is known of the start of a leaving ray. */
typedef struct start {
  const geometry *g;
  vec3 point, normal; /* of the source triangle */
  double rounding;    /* how far off Embree may see it, world units */
} start;

/* The point of the source triangle nearest to `origin` that keeps INSIDE * rounding from its edges. */
static vec3 pull_inside(const triangle *t, vec3 origin, double rounding)
{
  const double area = v3_length(t->normal); /* twice the triangle's; divided by an edge it is the height above it */
  const double opposite[3] = {v3_length(v3_sub(t->edge2, t->edge1)), v3_length(t->edge2), v3_length(t->edge1)};
  double b[3], margin[3], excess = 0;
  triangle_barycentric(t, origin, &b[1]);
  b[0] = 1 - b[1] - b[2];
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

static start start_of(const geometry *g, const query *q)
{
  const bent_ray *ray = q->leaving;
  if (!ray) return (start){g, .point = q->start};
  const instance *i = &g->instances[ray->source_instance];
  const double coordinate = fmax(fabs(q->start.x), fmax(fabs(q->start.y), fabs(q->start.z)));
  const double rounding = i->float_error_offset + i->float_error_scale * coordinate;
  const triangle t = triangle_of(g, ray->source_instance, ray->source_triangle);
  return (start){g, pull_inside(&t, q->start, rounding), v3_normalize(t.normal), rounding};
}

/* Whether a triangle so near that Embree cannot tell is met by the ray that starts at q->start towards q->departure. */
static int is_met(const triangle *t, const query *q, const start *s)
{
  const double slope = v3_dot(t->normal, q->departure), size = v3_length(t->normal);
  const double length = v3_dot(t->normal, v3_sub(t->v0, q->start)) / slope, cosine = fabs(slope) / size;
  if (!(length * cosine > 0x1p-24 * s->rounding)) return 0; /* behind, or where the ray starts */
  const vec3 point = v3_mad(q->departure, length, q->start);
  double b[2];
  triangle_barycentric(t, point, b);
  if (barycentric_outside(b) < 1e-12) return 1;
  /* Beside the triangle, but the query was off by as much. A neighbor at an angle is met there or its own neighbor is;
   * one that goes on straight, concave only by rounding of its vertices, is not. */
  const double turn = v3_length(v3_cross(s->normal, t->normal)) / size;
  triangle_clamp(t, b);
  return turn > 1e-3 && v3_length(v3_sub(point, triangle_point(t, b))) * cosine <= 4 * INSIDE * s->rounding;
}

static int is_passed_over(const found *f, const query *q, const start *s, double span)
{
  const bent_ray *ray = q->leaving;
  if (!ray) return 0;
  if (f->instance == ray->source_instance && f->triangle == ray->source_triangle) return 1;
  const triangle t = triangle_of(s->g, f->instance, f->triangle);
  const double cosine = fabs(v3_dot(t.normal, q->span)) / (span * v3_length(t.normal));
  const int in_doubt = f->at * span * cosine <= 2 * INSIDE * s->rounding;
  return in_doubt && !is_met(&t, q, s);
}

int geometry_query(const geometry *g, const query *q, found *out)
{
  const embree_table *e = embree();
  const start s = start_of(g, q);
  const double span = q->leaving ? v3_length(q->span) : 1;
  const double early = (q->leaving ? EARLY * s.rounding / span : 0) + fmax(-q->near, 0);
  const vec3 origin = v3_mad(q->span, -early, s.point);
  float from = q->near > 0 ? (float)(q->near + early) : 0;
  for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
    embree_ray ray = {.origin = {(float)origin.x, (float)origin.y, (float)origin.z},
                      .near = from,
                      .direction = {(float)q->span.x, (float)q->span.y, (float)q->span.z},
                      .far = (float)(q->far + early),
                      .mask = q->visibility,
                      .geometry = EMBREE_INVALID,
                      .instance = EMBREE_INVALID};
    e->intersect1(g->top, &ray, NULL);
    if (ray.geometry == EMBREE_INVALID) return 0;
    *out = (found){.instance = (int)ray.instance, .triangle = (int)ray.triangle, .at = ray.far - early,
                   .b = {ray.u, ray.v}};
    if (!is_passed_over(out, q, &s, span)) return 1;
    from = nextafterf(ray.far, INFINITY);
  }
  return 0;
}
