/* Straight rays: one Embree query, its answer recomputed in double precision.
 *
 * A ray that leaves a surface must not meet it again at length 0. The triangle that it leaves cannot be met twice by a
 * straight line, so it is passed over by its number. Its neighbors lie within rounding of the start: for Embree, in
 * float32, the start may be on the wrong side of them. So the query starts a little early and a little inside the
 * triangle, by a bound of Embree's rounding, and hits that near are put to double precision: is the triangle met, and
 * ahead of the start?
 */
#include "geometry/flat.h"

#include "geometry/hit.h"

/* Hits passed over before giving up; only surfaces that coincide with the source to rounding are passed over. */
enum { ATTEMPTS = 16 };

/* How far the query's start is moved along the ray, and away from the source's edges, in bounds of rounding. */
static const double EARLY = 4, INSIDE = 8;

/* A hit in double precision: the point where the true ray meets the triangle's plane. */
typedef struct crossing {
  double length, cosine;
  double b[2];    /* barycentric weights of vertices 1 and 2 */
  double outside; /* how far b lies outside the triangle; NaN if ray and plane are parallel */
} crossing;

static crossing cross(const triangle *t, vec3 origin, vec3 direction)
{
  crossing c;
  const double slope = v3_dot(t->normal, direction);
  c.length = v3_dot(t->normal, v3_sub(t->v0, origin)) / slope;
  c.cosine = fabs(slope) / v3_length(t->normal);
  triangle_barycentric(t, v3_mad(direction, c.length, origin), c.b);
  c.outside = fmax(fmax(-c.b[0], -c.b[1]), c.b[0] + c.b[1] - 1);
  return c;
}

/* What the true start of a ray, in double precision, says about a hit that lies within rounding of it. `normal` is the
 * source's. */
static int is_met(const triangle *t, vec3 normal, vec3 origin, vec3 direction, const crossing *c, double rounding)
{
  if (!(c->length * c->cosine > 0x1p-24 * rounding)) return 0; /* behind, or where the ray starts */
  if (c->outside < 1e-12) return 1;
  /* Beside the triangle, but the query was off by as much. A neighbor at an angle is met there or its own neighbor is;
   * one that goes on straight, concave only by rounding of its vertices, is not. */
  const double turn = v3_length(v3_cross(normal, t->normal)) / v3_length(t->normal);
  double b[2] = {c->b[0], c->b[1]};
  barycentric_clamp(b);
  const vec3 beside = v3_sub(v3_mad(direction, c->length, origin), triangle_point(t, b));
  return turn > 1e-3 && v3_length(beside) * c->cosine <= 4 * INSIDE * rounding;
}

/* Moves Embree's answer onto the true ray. Seen almost edge-on, the plane is met too far away to be of use; then
 * Embree's own point of the triangle stands. Returns the length along the ray. */
static double refine(const triangle *t, vec3 origin, vec3 direction, crossing *c, const embree_ray *query, bent_hit *hit)
{
  const int useful = c->outside < 0.01;
  if (!useful) c->b[0] = query->u, c->b[1] = query->v;
  barycentric_clamp(c->b);
  const vec3 position = triangle_point(t, c->b);
  v3_to(hit->position, position);
  hit->barycentric[0] = c->b[0], hit->barycentric[1] = c->b[1];
  return useful ? c->length : v3_dot(v3_sub(position, origin), direction);
}

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

double flat_segment(const geometry *g, const bent_ray *ray, vec3 origin, vec3 direction, double near, double far,
                    int source, bent_hit *hit)
{
  const embree_table *e = embree();
  source = source && ray->source_instance >= 0;
  const double rounding = source ? float_error(&g->instances[ray->source_instance], origin) : 0;
  const double early = EARLY * rounding;
  vec3 start = origin, normal = v3(0, 0, 0);
  if (source) {
    const triangle t = triangle_of(g, ray->source_instance, ray->source_triangle);
    start = v3_mad(direction, -early, pull_inside(&t, origin, rounding));
    normal = v3_normalize(t.normal);
  }
  float from = (float)(near > 0 ? near + early : 0);
  for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
    embree_ray query = {.origin = {(float)start.x, (float)start.y, (float)start.z},
                        .near = from,
                        .direction = {(float)direction.x, (float)direction.y, (float)direction.z},
                        .far = (float)(far + early),
                        .mask = ray->visibility,
                        .geometry = EMBREE_INVALID,
                        .instance = EMBREE_INVALID};
    e->intersect1(g->top, &query, NULL);
    if (query.geometry == EMBREE_INVALID) break;
    hit->instance = (int)query.instance, hit->triangle = (int)query.triangle;
    const triangle t = triangle_of(g, hit->instance, hit->triangle);
    crossing c = cross(&t, origin, direction);
    const int in_doubt = source && (query.far - early) * c.cosine <= 2 * INSIDE * rounding;
    const int is_source = source && hit->instance == ray->source_instance && hit->triangle == ray->source_triangle;
    if (!is_source && (!in_doubt || is_met(&t, normal, origin, direction, &c, rounding))) {
      const double length = refine(&t, origin, direction, &c, &query, hit);
      return length > near ? length : near;
    }
    from = nextafterf(query.far, INFINITY);
  }
  hit->instance = hit->triangle = -1;
  return INFINITY;
}

void flat_intersect(const geometry *g, const bent_ray *ray, bent_hit *hit)
{
  const vec3 origin = v3_from(ray->origin), direction = v3_normalize(v3_from(ray->direction));
  *hit = (bent_hit){.fate = BENT_ESCAPED, .instance = -1, .triangle = -1, .position = {NAN, NAN, NAN},
                    .length = INFINITY, .sky = -1};
  v3_to(hit->direction, direction);
  const double length = flat_segment(g, ray, origin, direction, ray->length_min, ray->length_max, 1, hit);
  if (length < INFINITY) hit->fate = BENT_HIT, hit->length = length;
}
