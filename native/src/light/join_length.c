/* The drawn length of a joint: straight pieces outside of spheres, and inside a quadrature along the radius.
 *
 * In an isotropic chart the scene's lengths and angles are those of space times a factor, so a ray is one of geometrical
 * optics in a medium of index n(R): it keeps b = n R sin(angle to the radius) (Bouguer), and its drawn length is the
 * integral of dR / sqrt(1 - b^2 / (n R)^2). Lengths in the areal chart, which is not isotropic, are that of dr
 * sqrt(1 + b^2 (1 - f) / r^2) / sqrt(1 - b^2 f / r^2), f = 1 - 2 M / r. With x = log(R / R_critical) the root is about that of
 * x^2 - x_turn^2 near the photon sphere or throat, or of x^2 + w^2 where the ray does not turn: both are smooth in t with
 * x = x_turn cosh t or w sinh t, however near to critical. */
#include "light/join.h"
#include "spacetime/gauss_legendre.h"

enum { RULE = 2, NODES = 16 };

/* A lens as a medium; lengths in world units. */
typedef struct medium {
  bent_spacetime_kind kind;
  int areal;
  double mass, core; /* core: half a throat */
} medium;

static medium medium_of(const lens *l)
{
  const bent_spacetime *s = &l->spacetime;
  return (medium){s->kind, s->kind == BENT_KERR || s->chart == BENT_CHART_AREAL, s->mass * l->scale,
                  s->throat_radius * l->scale / 2};
}

/* n R and, for what is drawn in the areal chart, the rest of the integrand. */
static double optical_radius(const medium *m, double radius, double b, double *rest)
{
  *rest = 1;
  if (m->kind == BENT_ELLIS) return radius + m->core * m->core / radius;
  if (!m->areal) {
    const double half = m->mass / (2 * radius), plus = 1 + half;
    return radius * plus * plus * plus / (1 - half);
  }
  const double f = 1 - 2 * m->mass / radius, across = b / radius;
  *rest = sqrt(1 + across * across * (1 - f));
  return radius / sqrt(f);
}

/* Where a ray of impact parameter b turns on the side of the photon sphere or throat where `radius` is; 0: nowhere. */
static double turning_radius(const medium *m, double b, double radius)
{
  if (m->kind == BENT_ELLIS) return b > 2 * m->core ? (b + sqrt(b * b - 4 * m->core * m->core)) / 2 : 0;
  const double critical = sqrt(27) * m->mass;
  if (!(b > critical)) return 0;
  const double angle = acos(-critical / b) / 3, scale = 2 * b / sqrt(3); /* roots of r^3 - b^2 (r - 2 M) */
  const double outer = scale * cos(angle), inner = scale * cos(angle + 4 * M_PI / 3);
  const double above = m->areal ? radius : radius * (1 + m->mass / (2 * radius)) * (1 + m->mass / (2 * radius));
  const double r = above > 3 * m->mass ? outer : inner;
  return m->areal ? r : (r - m->mass + sqrt(max2(r * (r - 2 * m->mass), 0))) / 2;
}

/* The photon sphere, or the throat: where n R is least. */
static double critical_radius(const medium *m)
{
  return m->kind == BENT_ELLIS ? m->core : m->areal ? 3 * m->mass : (1 + sqrt(3) / 2) * m->mass;
}

/* ds / dx along a ray, x = log(R / R_critical). */
static double length_by_log(const medium *m, double b, double critical, double x)
{
  const double radius = critical * exp(x);
  double rest;
  const double across = b / optical_radius(m, radius, b, &rest);
  return rest * radius / sqrt(max2(1 - across * across, 1e-30));
}

/* From the turning radius, x = x_turn cosh t with t = 0, to another one. */
static double from_turn(const medium *m, double b, double turn, double radius)
{
  const double critical = critical_radius(m), x = log(turn / critical);
  const double end = acosh(max2(log(radius / critical) / x, 1));
  double sum = 0;
  for (int i = 0; i < NODES; i++) {
    const double *pair = gauss_pairs[gauss_first[RULE] + i / 2], t = end / 2 * (1 + (i % 2 ? pair[0] : -pair[0]));
    sum += pair[1] * length_by_log(m, b, critical, x * cosh(t)) * fabs(x) * sinh(t);
  }
  return sum * end / 2;
}

/* Between two radii of a ray that turns nowhere, x = w sinh t. */
static double without_turn(const medium *m, double b, double low, double high)
{
  double rest;
  const double critical = critical_radius(m), part = b / optical_radius(m, critical, 0, &rest), part2 = part * part;
  const double w = sqrt(max2(1 - part2, 1e-12) / max2(part2, 0.01) / (m->areal ? 3 : 1));
  const double begin = asinh(log(low / critical) / w), end = asinh(log(high / critical) / w);
  double sum = 0;
  for (int i = 0; i < NODES; i++) {
    const double *pair = gauss_pairs[gauss_first[RULE] + i / 2];
    const double t = (begin + end) / 2 + (end - begin) / 2 * (i % 2 ? pair[0] : -pair[0]);
    sum += pair[1] * length_by_log(m, b, critical, w * sinh(t)) * w * cosh(t);
  }
  return sum * (end - begin) / 2;
}

/* One end of a joint: how far it is to the sphere along its ray, and the ray there. */
typedef struct end {
  double leg, radius, cosine, sine; /* of the angle between the outward direction and the way along the joint from here */
} end;

static end end_of(const lens *l, vec3 at, vec3 direction)
{
  const vec3 out = v3_sub(at, l->center);
  end e = {.radius = v3_length(out)};
  if (e.radius > l->radius) {
    const double along = v3_dot(out, direction), half2 = l->radius * l->radius - v3_dot(out, out) + along * along;
    e.leg = -along - sqrt(max2(half2, 0));
    const vec3 rim = v3_mad(direction, e.leg, out);
    e.radius = l->radius;
    e.cosine = v3_dot(rim, direction) / l->radius, e.sine = v3_length(v3_cross(rim, direction)) / l->radius;
  } else {
    e.cosine = v3_dot(out, direction) / e.radius, e.sine = v3_length(v3_cross(out, direction)) / e.radius;
  }
  return e;
}

double join_length(const geometry *g, vec3 from, vec3 to, const joint *j)
{
  if (joint_is_straight(j)) return v3_length(v3_sub(to, from));
  const lens *l = &g->lenses[j->first_lens];
  if (l->spacetime.kind == BENT_KERR && l->spacetime.spin != 0) return v3_length(v3_sub(to, from));
  const int far = j->through && l->exit >= 0;
  const end a = end_of(l, from, j->launch), b = end_of(far ? &g->lenses[l->exit] : l, to, v3_scale(j->arrival, -1));
  const medium m = medium_of(l);
  double unused;
  const double impact = optical_radius(&m, a.radius, 0, &unused) * a.sine, legs = a.leg + b.leg;
  if (far) return legs + without_turn(&m, impact, m.core, a.radius) + without_turn(&m, impact, m.core, b.radius);
  const double low = min2(a.radius, b.radius), high = max2(a.radius, b.radius), turn = turning_radius(&m, impact, low);
  if (!(turn > 0)) return legs + without_turn(&m, impact, low, high);
  const double first = from_turn(&m, impact, turn, a.radius), second = from_turn(&m, impact, turn, b.radius);
  return legs + ((a.cosine < 0) == (b.cosine < 0) ? first + second : fabs(first - second));
}
